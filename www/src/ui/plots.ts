// Curves of the run: position error and heading error with the 3σ that the filter claims, and time per scan.

import { css, html, type PropertyValues, type TemplateResult, unsafeCSS } from "lit";
import uPlot from "uplot";
import plotCss from "uplot/dist/uPlot.min.css";
import { SAMPLE } from "../protocol.js";
import type { Topic } from "../store.js";
import { SlamElement } from "./element.js";
import { shared } from "./style.js";

interface Curve {
  title: string;
  unit: string;
  value: number;
  /** Column of the 3σ bound. */
  bound?: number;
  digits: number;
  colour: string;
}

const CURVES: readonly Curve[] = [
  { title: "Position error", unit: "m", value: SAMPLE.positionError, bound: SAMPLE.positionSigma3, digits: 3, colour: "estimate" },
  { title: "Heading error", unit: "°", value: SAMPLE.headingError, bound: SAMPLE.headingSigma3, digits: 2, colour: "truth" },
  { title: "Time per scan", unit: "ms", value: SAMPLE.scanMillis, digits: 2, colour: "path" },
];

const HEIGHT = 84;
const REDRAW_MILLIS = 250;

export class SlamPlots extends SlamElement {
  static override styles = [
    unsafeCSS(plotCss),
    shared,
    css`
      :host { display: block; }
      h2 { margin-bottom: 8px; }
      figure { margin: 0 0 6px; }
      figcaption { display: flex; justify-content: space-between; font-size: 12.5px; margin-bottom: 2px; }
      figcaption .num { color: var(--ink); }
      .key { display: inline-flex; align-items: center; gap: 5px; color: var(--muted); }
      .key i { width: 12px; height: 9px; border-radius: 2px; background: color-mix(in srgb, var(--band) 28%, transparent); border-top: 1.5px solid var(--band); }
      .plot { height: 84px; }
      .uplot, .u-wrap { font-family: var(--mono); }
      .u-cursor-x, .u-cursor-y { border-color: var(--muted) !important; }
    `,
  ];

  protected override readonly topics: readonly Topic[] = ["theme", "run"];
  #plots: uPlot[] = [];
  #drawn = -1;
  #drawnAt = 0;
  #theme = "";

  override connectedCallback(): void {
    super.connectedCallback();
    this.store.on("moment", () => this.#feed());
    new ResizeObserver(() => {
      for (const plot of this.#plots) plot.setSize({ width: this.clientWidth, height: HEIGHT });
      this.#drawn = -1;
      this.#feed();
    }).observe(this);
  }

  override render(): TemplateResult {
    return html`<h2>Plots</h2>
      ${CURVES.map(
        (curve, i) => html`<figure aria-label=${`${curve.title} over time`}>
          <figcaption><span>${curve.title} ${curve.bound === undefined ? "" : html`<span class="key"><i class="band-${i}"></i>3σ</span>`}</span><span class="num" id="now-${i}" data-testid="plot-${i}"></span></figcaption>
          <div class="plot" id="plot-${i}"></div>
        </figure>`,
      )}`;
  }

  override updated(_changed: PropertyValues): void {
    const style = getComputedStyle(this);
    const theme = style.color;
    if (theme === this.#theme) return;
    this.#theme = theme;
    for (const plot of this.#plots) plot.destroy();
    this.#plots = CURVES.map((curve, i) => this.#make(curve, i));
    this.#drawn = -1;
    this.#feed();
  }

  #make(curve: Curve, i: number): uPlot {
    const probe = this.renderRoot.querySelector<HTMLElement>(`#now-${i}`);
    const resolve = (name: string): string => {
      if (!probe) return "gray";
      probe.style.setProperty("color", `var(--${name})`);
      const colour = getComputedStyle(probe).color;
      probe.style.removeProperty("color");
      return colour;
    };
    const [line, muted, rule] = [resolve(`map-${curve.colour}`), resolve("muted"), resolve("line")];
    this.renderRoot.querySelector<HTMLElement>(`.band-${i}`)?.style.setProperty("--band", line);
    const faint = line.replace(/^rgb\((.*)\)$/, (_, parts: string) => `rgba(${parts}, 0.2)`);
    const axis = { stroke: muted, font: "11px IBM Plex Mono, monospace", ticks: { show: false }, grid: { stroke: rule, width: 1 } };
    const series: uPlot.Series[] = [{}, { stroke: line, width: 1.6, points: { show: false } }];
    if (curve.bound !== undefined) series.splice(1, 0, { stroke: faint, fill: faint, width: 1, points: { show: false } });
    const options: uPlot.Options = {
      width: Math.max(this.clientWidth, 100),
      height: HEIGHT,
      series,
      legend: { show: false },
      cursor: { y: false, sync: { key: "slamlab" }, points: { size: 6 }, drag: { x: true, y: false } },
      padding: [6, 6, 0, 0],
      scales: { x: { time: false }, y: { range: (_u, _min, max) => [0, Math.max(max * 1.1, 1e-6)] } },
      axes: [
        { ...axis, size: 20, gap: 2, space: 60, values: (_u, ticks) => ticks.map((t) => `${t} s`) },
        { ...axis, size: 44, gap: 4, space: 28 },
      ],
      hooks: { setCursor: [() => this.#readout()] },
    };
    const host = this.renderRoot.querySelector<HTMLElement>(`#plot-${i}`);
    return new uPlot(options, columns(this.store.history.columns, curve), host ?? undefined);
  }

  #feed(): void {
    const { history, playing } = this.store;
    const now = performance.now();
    if (history.version === this.#drawn || (playing && now - this.#drawnAt < REDRAW_MILLIS) || this.offsetParent === null) return;
    this.#drawn = history.version;
    this.#drawnAt = now;
    this.#plots.forEach((plot, i) => {
      const curve = CURVES[i];
      if (curve) plot.setData(columns(history.columns, curve));
    });
    this.#readout();
  }

  /** The number under the cursor, or else the latest. */
  #readout(): void {
    this.#plots.forEach((plot, i) => {
      const curve = CURVES[i];
      const target = this.renderRoot.querySelector(`#now-${i}`);
      if (!curve || !target) return;
      const values = plot.data[plot.data.length - 1] ?? [];
      const at = plot.cursor.idx ?? values.length - 1;
      const value = values[at];
      target.textContent = typeof value === "number" ? `${value.toFixed(curve.digits)} ${curve.unit}` : "–";
    });
  }
}

function columns(all: readonly number[][], curve: Curve): uPlot.AlignedData {
  const gaps = (index: number): (number | null)[] => (all[index] ?? []).map((v) => (Number.isFinite(v) ? v : null));
  const time = all[SAMPLE.time] ?? [];
  return curve.bound === undefined ? [time, gaps(curve.value)] : [time, gaps(curve.bound), gaps(curve.value)];
}

customElements.define("slam-plots", SlamPlots);
