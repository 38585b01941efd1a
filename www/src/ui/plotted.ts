// A component with plots: how all of them look, that they follow its width, and that what plots
// comes when the first of them is seen.

import { type CSSResultGroup, type CSSResultOrNative, css, unsafeCSS } from "lit";
import type uPlot from "uplot";
import plotCss from "uplot/dist/uPlot.min.css";
import { bundle } from "../bundle.js";
import { SlamElement } from "./element.js";
import { numberAxes } from "./plot_style.js";

/** What makes plots. */
export type Plotter = typeof uPlot;

let plotter: Plotter | null = null;
let coming: Promise<void> | null = null;

export abstract class SlamPlotted extends SlamElement {
  /** Of each plot, CSS pixels. */
  protected abstract readonly height: number;
  protected plots: readonly uPlot[] = [];
  /** Whether it was to draw before there was what draws. */
  #isOwed = false;

  protected static override finalizeStyles(own: CSSResultGroup = []): CSSResultOrNative[] {
    return super.finalizeStyles([unsafeCSS(plotCss), css`.uplot, .u-wrap { font-family: var(--mono); } .u-wrap .drawn { display: none; }`, own]);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    new ResizeObserver(() => this.resized()).observe(this);
    this.store.on("frame", () => this.#settle());
  }

  /** Makes the plots of what there is, in their places. */
  protected abstract draw(make: Plotter): readonly uPlot[];

  override updated(): void {
    for (const plot of this.plots) plot.destroy();
    this.plots = plotter ? this.draw(plotter) : [];
    this.#isOwed = plotter === null;
    this.#settle();
  }

  /** Draws what could not be drawn yet, once somebody sees it and the robot has something to show:
      before that, whether the tour hides it is not decided. */
  #settle(): void {
    if (!this.#isOwed || this.clientWidth === 0 || !this.store.status) return;
    this.#isOwed = false;
    coming ??= bundle(this.store, "plotter.js", "The part that draws curves").then((part) => {
      // Where it did not come it is asked for at the next drawing, not at each frame.
      plotter = (part as typeof import("./plotter.js") | null)?.default ?? null;
      coming = null;
    });
    void coming.then(() => plotter && this.requestUpdate());
  }

  protected resized(): void {
    this.#settle();
    for (const plot of this.plots) plot.setSize({ width: this.#width, height: this.height });
  }

  /** What plots have in common; `unit` is that of the axis below. */
  protected frame(host: HTMLElement, unit: string): Omit<uPlot.Options, "series"> {
    return {
      width: this.#width, height: this.height, legend: { show: false }, cursor: { y: false, drag: { x: true, y: false } },
      padding: [6, 6, 0, 0], scales: { x: { time: false } }, axes: numberAxes(host, unit), plugins: [still()],
    };
  }

  get #width(): number {
    return Math.max(this.clientWidth, 100);
  }
}

/** What is seen of a plot is a bitmap, made when it is drawn: browsers without a graphics card copy
    every 2D canvas for each picture of the page, whether it changed or not. */
function still(): uPlot.Plugin {
  let seen: ImageBitmapRenderingContext | null = null;
  return { hooks: { draw: ({ ctx: { canvas } }) => {
    const { width, height } = canvas;
    seen ??= placeBeside(canvas);
    const copy = new OffscreenCanvas(width, height);
    copy.getContext("2d")?.drawImage(canvas, 0, 0);
    seen?.transferFromImageBitmap(copy.transferToImageBitmap());
  } } };
}

/** Where the bitmap of a canvas is seen in its place; null where there are none. */
function placeBeside(canvas: HTMLCanvasElement): ImageBitmapRenderingContext | null {
  const place = document.createElement("canvas");
  const context = place.getContext("bitmaprenderer");
  if (!context) return null;
  canvas.classList.add("drawn");
  canvas.after(place);
  return context;
}
