// Curves of the run over its time, each with the bound or band in which it should lie.

import { css, type CSSResultGroup, nothing, type TemplateResult } from "lit";
import type uPlot from "uplot";
import type { SavedFile } from "../protocol/module.js";
import { SAMPLE } from "../protocol/sample.js";
import { type Column, csvOf } from "../csv.js";
import type { History } from "../history.js";
import { download, fileName } from "../save.js";
import type { Topic } from "../store.js";
import { html, t } from "../words.js";
import { axisEnd } from "./axis_end.js";
import { fixed } from "./format.js";
import { icons } from "./icons.js";
import { inTurn } from "./in_turn.js";
import { colourOf, faint } from "./plot_style.js";
import { type Plotter, SlamPlotted } from "./plotted.js";

export interface Curve {
  title: string;
  /** Its meaning, shown as the title's tooltip. */
  meaning: string;
  unit: string;
  /** Column of the value. */
  value: number;
  /** Title and meaning if there are only bounds: without truth there is no error. */
  boundsAlone?: { title: string; meaning: string };
  /** Columns of the bounds, the upper first; the lower one is optional. */
  bounds: readonly number[];
  /** What the bounds are. */
  key: string;
  digits: number;
  colour: string;
  /** The value may be negative: the axis is symmetric about 0. */
  isSigned?: true;
  /** Name of the value, among others in the same plot. */
  name?: string;
  beside?: readonly { name: string; value: number; colour: string }[];
  /** The end of the axis; by default the end of the values. */
  most?: number;
}

const REDRAW_MILLIS = 250;
/** A plot takes as much of a picture's time as this many texts (in_turn.ts). */
const PLOT_WEIGHT = 3;

/** Least range of an axis: that of an all-zero curve would be labelled 0, 0, 0. */
const LEAST_RANGE = 1e-3;
/** Half the width, and the height, of a mark where a curve leaves the plot, CSS pixels. */
const BEYOND = 4;

export abstract class SlamCharts extends SlamPlotted {
  static override styles: CSSResultGroup = css`
    h2 { margin-bottom: 8px; }
    figure { margin: 0 0 6px; }
    figcaption { display: flex; justify-content: space-between; font-size: 12.5px; margin-bottom: 2px; }
    figcaption .num { color: var(--ink); }
    .key { display: inline-flex; align-items: center; gap: 5px; color: var(--muted); }
    .key { margin-left: 4px; }
    .key svg { width: 12px; height: 4px; }
    .key i { width: 12px; height: 9px; border-radius: 2px; background: color-mix(in srgb, var(--band) 28%, transparent); border-top: 1.5px solid var(--band); }
    .plot { height: 84px; }
    .none { margin: 0 0 8px; font-size: 12.5px; color: var(--muted); }
    .csv { min-height: 32px; padding: 2px 10px; font-size: 12.5px; }
    @media (pointer: coarse) { .csv { min-height: 44px; } }
    .u-cursor-x, .u-cursor-y { border-color: var(--muted) !important; }
  `;

  protected override readonly topics: readonly Topic[] = ["theme", "run"];
  protected override readonly height = 84;
  protected abstract readonly curves: readonly Curve[];
  /** Prefix of the identifiers that tests use. */
  protected readonly names: string = "plot";

  /** Where the columns are; the first is the time. */
  protected get history(): History {
    return this.store.history;
  }

  /** Which curves have only bounds. */
  #alone: readonly boolean[] = [];
  #drawn = -1;
  #drawnAt = 0;
  #theme = "";
  /** Plots that are visible; the others are drawn when they come into sight. */
  readonly #inSight = new Set<Element>();
  readonly #sight = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) this.#inSight[isIntersecting ? "add" : "delete"](target);
    if (entries.some(({ isIntersecting }) => isIntersecting)) {
      this.#drawn = -1;
      this.feed();
    }
  });

  override connectedCallback(): void {
    super.connectedCallback();
    this.store.on("frame", () => this.feed());
  }

  protected override resized(): void {
    super.resized();
    this.#drawn = -1;
    this.feed();
  }

  override render(): TemplateResult {
    return html`${this.curves.map((curve, i) => {
      const { title, meaning } = this.#words(i, curve);
      return html`<figure id="figure-${i}" aria-label=${t`${title} over time`}>
        <figcaption title=${meaning}><span>${title} ${[{ name: curve.name, colour: curve.colour }, ...curve.beside ?? []].map(({ name, colour }) => name === undefined ? nothing : html`<span class="key"><svg viewBox="0 0 12 4" aria-hidden="true"><path d="M0 2h12" stroke="var(--map-${colour})" stroke-width="2.5"/></svg>${name}</span> `)}${curve.key === "" ? nothing : html`<span class="key"><i class="band-${i}"></i>${curve.key}</span>`} <span class="key num" id="beyond-${i}" title="The picture ends below a few rare values: this is the farthest of them" data-testid="beyond-${curve.value}"></span></span><span class="num" id="now-${i}" data-testid="${this.names}-${curve.value}"></span></figcaption>
        <div class="plot" id="plot-${i}"></div>
      </figure>`;
    })}
      ${this.note()}
      <button class="csv" data-testid="csv" title="Save these curves as a table: CSV with units, times in seconds" @click=${this.press(() => this.#save())}>${icons.save} CSV</button>`;
  }

  /** Text below the curves. */
  protected note(): TemplateResult | typeof nothing {
    return nothing;
  }

  #words(i: number, curve: Curve): { title: string; meaning: string } {
    return this.#alone[i] && curve.boundsAlone ? curve.boundsAlone : curve;
  }

  #save(): void {
    const { store, history: { keep } } = this;
    const table = this.table();
    if (!table) {
      store.set("toast", { toast: { level: "warn", text: "There is nothing to save yet: the curves are empty." } });
      return;
    }
    download(new Blob([table.bytes], { type: table.mime }), table.name);
    if (keep > 1) store.set("toast", { toast: { level: "info", text: t`The run is long: of every ${keep} scans the curves keep one, and so does the table.` } });
  }

  /** The drawn data, with all digits; null while there are none. */
  table(): SavedFile | null {
    const { store, history: { columns } } = this;
    const has = (index: number): boolean => columns[index]?.some(Number.isFinite) ?? false;
    const column = (index: number, title: string, unit: string): Column => ({ title, unit, values: columns[index] ?? [] });
    const curves = this.curves.flatMap((curve, i) => {
      const { title } = this.#words(i, curve);
      const bounds = curve.bounds.map((index, k) => column(index, `${title}, ${curve.key}${curve.bounds.length < 2 ? "" : k === 0 ? ", upper" : ", lower"}`, curve.unit));
      const beside = (curve.beside ?? []).map(({ name, value }) => column(value, `${title}, ${name}`, curve.unit));
      const indices = [curve.value, ...curve.bounds, ...(curve.beside ?? []).map(({ value }) => value)];
      return [column(curve.value, curve.name === undefined ? title : `${title}, ${curve.name}`, curve.unit), ...bounds, ...beside].filter((_, k) => has(indices[k] ?? -1));
    });
    if (curves.length === 0) return null;
    const table = csvOf([column(SAMPLE.time, "Time", "s"), ...curves]);
    return { name: `${fileName(store.title)}-${this.localName.replace(/^slam-/, "")}.csv`, mime: "text/csv;charset=utf-8", bytes: new TextEncoder().encode(table) };
  }

  override updated(): void {
    const theme = getComputedStyle(this).color;
    // Figures are added and removed with the data.
    const hosts = this.renderRoot.querySelectorAll<HTMLElement>(".plot");
    if (theme === this.#theme && hosts.length === this.plots.length && this.plots.every((plot) => plot.root.isConnected)) return;
    this.#theme = theme;
    super.updated();
    this.#sight.disconnect();
    this.#inSight.clear();
    for (const host of hosts) this.#sight.observe(host);
    this.#drawn = -1;
    this.feed();
  }

  protected override draw(make: Plotter): uPlot[] {
    const hosts = this.renderRoot.querySelectorAll<HTMLElement>(".plot");
    return [...hosts].flatMap((host, i) => this.curves[i] ? [this.#make(make, this.curves[i], host, i)] : []);
  }

  #make(make: Plotter, curve: Curve, host: HTMLElement, i: number): uPlot {
    const line = colourOf(host, `map-${curve.colour}`);
    this.renderRoot.querySelector<HTMLElement>(`.band-${i}`)?.style.setProperty("--band", line);
    const band = faint(line);
    const series: uPlot.Series[] = [{}, { stroke: line, width: 1.6, points: { show: false } }];
    const bands = curve.bounds.length === 2;
    series.splice(1, 0, ...curve.bounds.map(() => ({ stroke: band, width: 1, points: { show: false }, ...(bands ? {} : { fill: band }) })));
    for (const { colour } of curve.beside ?? []) series.push({ stroke: colourOf(host, `map-${colour}`), width: 1.6, points: { show: false } });
    const range = (plot: uPlot): [number, number] => {
      const most = curve.most ?? Math.max(1.1 * axisEnd(plot.data.slice(1), ...seen(plot)), LEAST_RANGE);
      return [curve.isSigned ? -most : 0, most];
    };
    const frame = this.frame(host, "s");
    // On a symmetric axis each half has its numbers.
    if (curve.isSigned && frame.axes?.[1]) frame.axes[1].space = 14;
    const options: uPlot.Options = {
      ...frame,
      series,
      ...(bands ? { bands: [{ series: [1, 2] as [number, number], fill: band }] } : {}),
      cursor: { y: false, sync: { key: "slamlab" }, points: { size: 6 }, drag: { x: true, y: false } },
      scales: { x: { time: false }, y: { range } },
      hooks: { setCursor: [(plot) => this.#tell(plot, i)], draw: [(plot) => this.#tellBeyond(i, markBeyond(plot, line))] },
    };
    return new make(options, columns(this.history.columns, curve), host);
  }

  /** Draws new samples, if the plots are visible. */
  protected feed(): void {
    const { history } = this;
    const { playing } = this.store;
    const now = performance.now();
    if (history.version === this.#drawn || (playing && now - this.#drawnAt < REDRAW_MILLIS) || this.offsetParent === null) return;
    this.#drawn = history.version;
    this.#drawnAt = now;
    const has = (index: number): boolean => history.columns[index]?.some(Number.isFinite) ?? false;
    const alone = this.curves.map(({ value, bounds }) => !has(value) && bounds.some(has));
    if (alone.join() !== this.#alone.join()) {
      this.#alone = alone;
      this.requestUpdate();
    }
    this.plots.forEach((plot, i) => {
      const curve = this.curves[i];
      if (!curve) return;
      // A recording has no truth, and some methods no innovations: an empty plot would only be
      // puzzling.
      const empty = (history.columns[SAMPLE.time]?.length ?? 0) > 0 && ![curve.value, ...curve.bounds].some(has);
      this.renderRoot.querySelector(`#figure-${i}`)?.toggleAttribute("hidden", empty);
      this.#tell(plot, i);
      const host = plot.root.parentElement;
      if (!host || !this.#inSight.has(host)) return;
      const draw = (): void => plot.setData(columns(history.columns, curve));
      if (playing) inTurn(plot, draw, PLOT_WEIGHT);
      else draw();
    });
  }

  /** Shows how far a curve goes beyond its plot, if it does. */
  #tellBeyond(i: number, farthest: number): void {
    const [curve, target] = [this.curves[i], this.renderRoot.querySelector(`#beyond-${i}`)];
    if (curve && target) write(target, farthest === 0 ? "" : `▲ ${fixed(farthest, curve.digits)} ${curve.unit}`.trim());
  }

  /** Shows the number under the cursor, or else the latest. */
  #tell(plot: uPlot, i: number): void {
    const curve = this.curves[i];
    const target = this.renderRoot.querySelector(`#now-${i}`);
    if (!curve || !target) return;
    const shown = this.#alone[i] ? curve.bounds.slice(0, 1) : [curve.value, ...(curve.beside ?? []).map(({ value }) => value)];
    const at = plot.cursor.idx ?? -1;
    const numbers = shown.map((index) => this.history.columns[index]?.at(at)).filter((value) => value !== undefined && Number.isFinite(value)) as number[];
    write(target, numbers.length > 0 ? `${numbers.map((value) => fixed(value, curve.digits)).join(" / ")} ${curve.unit}`.trim() : "–");
  }
}

/** Changes a text only if it differs: the browser lays out what is replaced, even by the same. */
function write(target: Element, text: string): void {
  if (target.textContent !== text) target.textContent = text;
}

/** The first and the last sample within the time axis. */
function seen(plot: uPlot): readonly [number, number] {
  return plot.series[0]?.idxs ?? [0, plot.data[0].length - 1];
}

/** Draws a mark at the edge wherever a value lies beyond it. Returns the farthest such value, 0 if
    there are none. */
function markBeyond(plot: uPlot, colour: string): number {
  let farthest = 0;
  const { ctx, bbox, data: [times, ...curves] } = plot;
  const { min = 0, max = 0 } = plot.scales["y"] ?? {};
  const [first, last] = seen(plot);
  const size = BEYOND * devicePixelRatio;
  ctx.fillStyle = colour;
  for (const curve of curves) {
    for (let i = first; i <= last; i += 1) {
      const value = curve[i] ?? 0;
      if (value <= (max ?? 0) && value >= (min ?? 0)) continue;
      const x = plot.valToPos(times[i] ?? 0, "x", true);
      const [edge, inward] = value > 0 ? [bbox.top, size] : [bbox.top + bbox.height, -size];
      ctx.beginPath();
      ctx.moveTo(x, edge);
      ctx.lineTo(x - size, edge + inward);
      ctx.lineTo(x + size, edge + inward);
      ctx.fill();
      if (Math.abs(value) > Math.abs(farthest)) farthest = value;
    }
  }
  return farthest;
}

function columns(all: readonly number[][], curve: Curve): uPlot.AlignedData {
  const gaps = (index: number): (number | null)[] => (all[index] ?? []).map((v) => (Number.isFinite(v) ? v : null));
  const time = all[SAMPLE.time] ?? [];
  return [time, ...curve.bounds.map(gaps), gaps(curve.value), ...(curve.beside ?? []).map(({ value }) => gaps(value))];
}
