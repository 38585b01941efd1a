// A component with plots: their common style, their width, and loading the plotting library when
// the first of them is seen.

import { type CSSResultGroup, type CSSResultOrNative, css, unsafeCSS } from "lit";
import type uPlot from "uplot";
import plotCss from "uplot/dist/uPlot.min.css";
import { bundle } from "../bundle.js";
import { SlamElement } from "./element.js";
import { numberAxes } from "./plot_style.js";

/** The constructor of plots. */
export type Plotter = typeof uPlot;

let plotter: Plotter | null = null;
let coming: Promise<void> | null = null;

export abstract class SlamPlotted extends SlamElement {
  /** Height of each plot, CSS pixels. */
  protected abstract readonly height: number;
  protected plots: readonly uPlot[] = [];
  /** Whether a drawing is pending because the library was not loaded yet. */
  #isOwed = false;

  protected static override finalizeStyles(own: CSSResultGroup = []): CSSResultOrNative[] {
    return super.finalizeStyles([unsafeCSS(plotCss), css`.uplot, .u-wrap { font-family: var(--mono); } .u-wrap .drawn { display: none; }`, own]);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    new ResizeObserver(() => this.resized()).observe(this);
    this.store.on("frame", () => this.#settle());
  }

  /** Creates the plots of the present data, in their places. */
  protected abstract draw(make: Plotter): readonly uPlot[];

  override updated(): void {
    for (const plot of this.plots) plot.destroy();
    this.plots = plotter ? this.draw(plotter) : [];
    this.#isOwed = plotter === null;
    this.#settle();
  }

  /** Catches up on a pending drawing once the component is visible and the robot has data: before
      that, it is not decided whether the tour hides it. */
  #settle(): void {
    if (!this.#isOwed || this.clientWidth === 0 || !this.store.status) return;
    this.#isOwed = false;
    coming ??= bundle(this.store, "plotter.js", "The part that draws curves").then((part) => {
      // If loading fails it is tried again at the next drawing, not at each frame.
      plotter = (part as typeof import("./plotter.js") | null)?.default ?? null;
      coming = null;
    });
    void coming.then(() => plotter && this.requestUpdate());
  }

  protected resized(): void {
    this.#settle();
    for (const plot of this.plots) plot.setSize({ width: this.#width, height: this.height });
  }

  /** The common options of plots; `unit` is that of the axis below. */
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

/** Takes a copy of one plot after the other. */
let copy: OffscreenCanvas | null = null;

/** Shows each plot as a bitmap, made when it is drawn: browsers without a graphics card copy every
    2D canvas for each picture of the page, whether it changed or not. */
function still(): uPlot.Plugin {
  let seen: ImageBitmapRenderingContext | null = null;
  return { hooks: { draw: ({ ctx: { canvas } }) => {
    const { width, height } = canvas;
    seen ??= placeBeside(canvas);
    copy ??= new OffscreenCanvas(width, height);
    if (copy.width !== width || copy.height !== height) Object.assign(copy, { width, height });
    copy.getContext("2d")?.drawImage(canvas, 0, 0);
    seen?.transferFromImageBitmap(copy.transferToImageBitmap());
  } } };
}

/** Adds a canvas that shows the bitmap instead; null if the browser has no bitmap contexts. */
function placeBeside(canvas: HTMLCanvasElement): ImageBitmapRenderingContext | null {
  const place = document.createElement("canvas");
  const context = place.getContext("bitmaprenderer");
  if (!context) return null;
  canvas.classList.add("drawn");
  canvas.after(place);
  return context;
}
