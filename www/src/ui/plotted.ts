// A component with plots: how all of them look, and that they follow its width.

import { type CSSResultGroup, type CSSResultOrNative, css, unsafeCSS } from "lit";
import uPlot from "uplot";
import plotCss from "uplot/dist/uPlot.min.css";
import { SlamElement } from "./element.js";
import { numberAxes } from "./plot_style.js";

export abstract class SlamPlotted extends SlamElement {
  /** Of each plot, CSS pixels. */
  protected abstract readonly height: number;
  protected plots: readonly uPlot[] = [];

  protected static override finalizeStyles(own: CSSResultGroup = []): CSSResultOrNative[] {
    return super.finalizeStyles([unsafeCSS(plotCss), css`.uplot, .u-wrap { font-family: var(--mono); }`, own]);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    new ResizeObserver(() => this.resized()).observe(this);
  }

  /** Makes the plots of what there is, in their places. */
  protected abstract draw(): readonly uPlot[];

  override updated(): void {
    for (const plot of this.plots) plot.destroy();
    this.plots = this.draw();
  }

  protected resized(): void {
    for (const plot of this.plots) plot.setSize({ width: this.#width, height: this.height });
  }

  /** What plots have in common; `unit` is that of the axis below. */
  protected frame(host: HTMLElement, unit: string): Omit<uPlot.Options, "series"> {
    return {
      width: this.#width, height: this.height, legend: { show: false }, cursor: { y: false, drag: { x: true, y: false } },
      padding: [6, 6, 0, 0], scales: { x: { time: false } }, axes: numberAxes(host, unit),
    };
  }

  get #width(): number {
    return Math.max(this.clientWidth, 100);
  }
}
