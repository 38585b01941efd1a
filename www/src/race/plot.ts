// The error curves of all runs side by side in one plot, with figures for each. A recording without
// truth shows each run's own uncertainty instead, and the distance of its trajectory from the one
// that is shown.

import { css, nothing, type TemplateResult } from "lit";
import type uPlot from "uplot";
import { apart } from "../compared.js";
import { type Column, csvOf } from "../csv.js";
import { SAMPLE } from "../protocol/sample.js";
import { download, fileName } from "../save.js";
import type { Store } from "../store.js";
import { fixed } from "../ui/format.js";
import { icons } from "../ui/icons.js";
import { colourOf } from "../ui/plot_style.js";
import { type Plotter, SlamPlotted } from "../ui/plotted.js";
import type { PaletteName } from "../view/palette.js";
import type { Scene } from "../view/scene.js";
import { html, t } from "../words.js";
import { DASHES, swatch } from "./swatch.js";

/** A run as the plot shows it. */
export interface Entry {
  readonly name: string;
  readonly colour: PaletteName;
  readonly place: number;
  readonly store: Store;
  readonly scene: Scene;
}

const REDRAW_MILLIS = 250;

export class SlamRacePlot extends SlamPlotted {
  static override styles = css`
    :host { margin-bottom: 14px; padding-bottom: 12px; border-bottom: 1px solid var(--line); }
    h2 { margin-bottom: 8px; }
    figure { margin: 0 0 6px; }
    figcaption { font-size: 12.5px; margin-bottom: 2px; }
    .plot { height: 150px; }
    table { width: 100%; border-collapse: collapse; font-size: 12px; margin-bottom: 8px; }
    th { font: 500 11px/1.2 var(--sans); color: var(--muted); text-align: right; padding: 0 0 5px 6px; }
    td { padding: 5px 0 5px 6px; text-align: right; font: 500 11.5px/1.2 var(--mono); white-space: nowrap; border-top: 1px solid var(--line); }
    th:first-child, td:first-child { text-align: left; padding-left: 0; }
    td:first-child { font: 500 12.5px/1.25 var(--sans); white-space: normal; }
    td span { display: flex; align-items: center; gap: 7px; }
    svg.line { width: 20px; height: 8px; }
    .csv { min-height: 32px; padding: 2px 10px; font-size: 12.5px; }
    @media (pointer: coarse) { .csv { min-height: 44px; } }
    .u-cursor-x { border-color: var(--muted) !important; }
  `;

  protected override readonly topics = ["theme", "run"] as const;
  protected override readonly height = 150;
  /** The runs; the first is the one that the page shows. */
  entries: readonly Entry[] = [];
  #make: Plotter | null = null;
  #drawnAt = -Infinity;
  #drawn = "";

  override render(): TemplateResult {
    const { hasTruth } = this;
    return html`<h2 id="race">Side by side</h2>
      <figure aria-labelledby="race"><figcaption>${hasTruth ? "Position error, m" : "Position uncertainty, 3σ, m: there is no truth here"}</figcaption><div class="plot"></div></figure>
      <table data-testid="race-table"><thead><tr><th scope="col">Run</th><th scope="col" title="At the last scan">now</th>
        ${hasTruth ? html`<th scope="col" title="Root mean square over all scans">RMS</th><th scope="col">most</th>` : html`<th scope="col" title="How far its way is from the one that is shown, at the same times: root mean square">apart</th>`}</tr></thead>
        <tbody>${this.entries.map((entry) => this.#row(entry))}</tbody></table>
      <button class="csv" data-testid="race-csv" title="Save these curves as a table: CSV with units, times in seconds" @click=${this.press(() => this.#save())}>${icons.save} CSV</button>`;
  }

  /** Shows these runs from here on. */
  show(entries: readonly Entry[]): void {
    this.entries = entries;
    this.#drawn = "";
    this.requestUpdate();
  }

  /** Draws new samples, if the plot is visible. */
  feed(): void {
    const now = performance.now();
    const state = this.entries.map(({ store }) => store.history.version).join();
    if (now - this.#drawnAt < REDRAW_MILLIS || state === this.#drawn || this.offsetParent === null) return;
    [this.#drawnAt, this.#drawn] = [now, state];
    const [plot] = this.plots;
    if (plot && this.#make) plot.setData(this.#data(this.#make));
    this.#tell();
  }

  /** Writes the latest figures into their cells, without rendering anything else. */
  #tell(): void {
    this.entries.forEach((entry, i) => {
      const cells = this.renderRoot.querySelectorAll(`#run-${i} td.num`);
      this.#figures(entry, i).forEach((figure, k) => {
        const cell = cells[k];
        if (cell) cell.textContent = figure;
      });
    });
  }

  get hasTruth(): boolean {
    const shown = this.entries[0]?.store;
    // A recording has truth if another file supplies it.
    return shown?.source === "sim" || (shown?.history.columns[SAMPLE.positionError]?.some(Number.isFinite) ?? false);
  }

  #row(entry: Entry): TemplateResult {
    const i = this.entries.indexOf(entry);
    return html`<tr id="run-${i}" data-testid="race-run-${entry.place}"><td><span>${swatch(entry.colour, entry.place)}${entry.name}</span></td>
      <td class="num"></td><td class="num"></td>${this.hasTruth ? html`<td class="num"></td>` : nothing}</tr>`;
  }

  #figures(entry: Entry, i: number): string[] {
    const values = this.#values(entry).filter(Number.isFinite);
    const now = fixed(values.at(-1) ?? NaN, 3);
    if (!this.hasTruth) {
      const [shown] = this.entries;
      const ways = [shown, entry].map((each) => each?.scene.trail.slice(0, each.scene.trailLength) ?? new Float32Array(0));
      return [now, i === 0 ? t("shown") : fixed(apart(ways[0]!, ways[1]!).rms, 3)];
    }
    const rms = Math.sqrt(values.reduce((sum, value) => sum + value * value, 0) / values.length);
    return [now, fixed(rms, 3), fixed(Math.max(...values), 3)];
  }

  #values({ store: { history } }: Entry): readonly number[] {
    return history.columns[this.hasTruth ? SAMPLE.positionError : SAMPLE.positionSigma3] ?? [];
  }

  #data(make: Plotter): uPlot.AlignedData {
    const each = this.entries.map((entry): uPlot.AlignedData => {
      const values = this.#values(entry).map((value) => (Number.isFinite(value) ? value : null));
      return [entry.store.history.columns[SAMPLE.time] ?? [], values];
    });
    return make.join(each);
  }

  protected override draw(make: Plotter): uPlot[] {
    this.#make = make;
    const host = this.renderRoot.querySelector<HTMLElement>(".plot");
    if (!host || this.entries.length === 0) return [];
    const series = this.entries.map(({ colour, place }): uPlot.Series => ({ stroke: colourOf(host, `map-${colour}`), width: 1.8, dash: [...DASHES[place] ?? []], points: { show: false }, spanGaps: true }));
    const scales = { x: { time: false }, y: { range: (_u: uPlot, _min: number, max: number): [number, number] => [0, Math.max(1.1 * max, 1e-6)] } };
    return [new make({ ...this.frame(host, "s"), series: [{}, ...series], scales }, this.#data(make), host)];
  }

  override updated(): void {
    super.updated();
    this.#tell();
  }

  #save(): void {
    const make = this.#make;
    if (!make) return;
    const [times, ...curves] = this.#data(make);
    const title = this.hasTruth ? "Position error" : "Position uncertainty, 3σ";
    const columns = curves.map((values, i): Column => ({ title: `${title}, ${this.entries[i]?.name ?? ""}`, unit: "m", values: [...values].map((value) => value ?? NaN) }));
    const table = csvOf([{ title: "Time", unit: "s", values: [...times] }, ...columns]);
    download(new Blob([table], { type: "text/csv;charset=utf-8" }), `${fileName(this.store.title)}-side-by-side.csv`);
  }
}

customElements.define("slam-race-plot", SlamRacePlot);
