// Calibration of the infra-red rangers: pairs typed, pasted or from a file; the curve, its
// residuals, and where it cannot be trusted.

import { css, type TemplateResult } from "lit";
import type uPlot from "uplot";
import type { Column } from "../csv.js";
import type { Calibration, Pairs } from "../protocol/module.js";
import { html } from "../words.js";
import "./csv_button.js";
import { fixed } from "./format.js";
import { icons } from "./icons.js";
import { filesOf, valueOf } from "./input.js";
import { colourOf } from "./plot_style.js";
import { type Plotter, SlamPlotted } from "./plotted.js";
import { tool } from "./style.js";

export class SlamCalibration extends SlamPlotted {
  static override styles = [
    tool,
    css`
      textarea { width: 100%; min-height: 150px; padding: 8px 10px; border: 1px solid var(--line); border-radius: 9px; background: var(--raised); color: inherit; font: 500 12.5px/1.5 var(--mono); resize: vertical; }
      .row { display: flex; gap: 8px; margin: 8px 0; }
      .row > * { flex: 1; }
      .row label.file { display: contents; }
      .row label.file .button { flex: 1; }
    `,
  ];

  protected override readonly topics = ["calibration", "run", "theme"] as const;
  protected override readonly height = 150;
  #pairs: Pairs | null = null;
  #open = false;

  override render(): TemplateResult {
    const { store } = this;
    this.toggleAttribute("hidden", store.source !== "sim");
    const { fit, error } = store.calibration;
    const pairs = this.#now;
    const applied = store.setup.calibration;
    const isApplied = applied !== null && applied.text === pairs.text && applied.variable === pairs.variable;
    return html`<details data-testid="calibration" @toggle=${this.#toggle}>
      <summary>Calibrate the IR rangers</summary>
      <p>Set up a board at known ranges, note what the ranger says, and fit a polynomial of the fifth degree. One pair a line; the first line names the columns: <code>range_m</code>, <code>range_cm</code> or <code>range_mm</code>, then <code>volts</code>, <code>millivolts</code> or <code>adc</code> (10 bits over 5 V).</p>
      <textarea data-testid="pairs" spellcheck="false" aria-label="Calibration pairs, one a line" aria-describedby="verdict" .value=${pairs.text} @input=${(e: Event) => this.#change({ text: valueOf(e) })}></textarea>
      <div class="row">
        <select data-testid="variable" aria-label="Polynomial of" @change=${(e: Event) => this.#change({ variable: valueOf(e) as Pairs["variable"] })}>
          <option value="per-volt" .selected=${pairs.variable === "per-volt"}>in 1/V</option>
          <option value="volts" .selected=${pairs.variable === "volts"}>in V</option>
        </select>
        <label class="file"><input type="file" accept=".csv,.txt,.tsv" data-testid="pairs-file" aria-label="Pairs from a file" @change=${this.#file}><span class="button">${icons.open} CSV…</span></label>
        <button @click=${() => this.#change({ text: store.offer.dataSheet })} title="The pairs of the data sheet, which the simulation uses">Data sheet</button>
      </div>
      <div id="verdict" aria-live="polite">${error ? html`<p class="bad" role="alert" data-testid="calibration-error">${error}</p>` : fit ? this.#verdict(fit) : ""}</div>
      <div ?hidden=${!fit || error !== ""}>
        <figure aria-label="Range over volts: the pairs and the curve"><figcaption><span>Range over volts, m</span></figcaption><div class="plot"></div></figure>
        <figure aria-label="Residuals over range"><figcaption><span>Curve less pair over range, mm</span></figcaption><div class="plot"></div></figure>
        ${fit ? html`<slam-csv .name=${"calibration-pairs"} .columns=${() => pairsOf(fit)}></slam-csv> <slam-csv .name=${"calibration-curve"} .columns=${() => curveOf(fit)}></slam-csv>` : ""}
      </div>
      <button class="apply" data-testid="apply-calibration" ?disabled=${!fit || error !== "" || isApplied} @click=${this.#apply}>${isApplied ? "In use" : "Use it for the simulated rangers"}</button>
      ${applied ? html`<button class="apply" data-testid="drop-calibration" @click=${() => this.client.start({ calibration: null, mode: "explore" })}>Back to the data sheet</button>` : ""}
    </details>`;
  }

  protected override draw(make: Plotter): uPlot[] {
    const { fit } = this.store.calibration;
    const [curve, residuals] = this.renderRoot.querySelectorAll<HTMLElement>(".plot");
    if (!fit || !this.#open || !curve || !residuals) return [];
    return [this.#curve(make, curve, fit), this.#residuals(make, residuals, fit)];
  }

  #verdict(fit: Calibration): TemplateResult {
    const [low = NaN, high = NaN] = fit.domain;
    const turns = Number.isFinite(fit.reversesAt);
    return html`<p data-testid="calibration-words">${fit.ranges.length} pairs, <b class="num">± ${fixed(1000 * fit.sigma, 1)} mm</b> about the curve. Volts outside of <b class="num">${fixed(low, 2)} to ${fixed(high, 2)} V</b> are clamped: a polynomial runs away there.</p>
      ${turns ? html`<p class="bad" role="alert" data-testid="not-monotonic">Not monotonic: from ${fixed(fit.reversesAt, 2)} V on the curve turns round, and one range stands for two. More pairs there, or 1/V, may mend it.</p>` : html`<p class="good" data-testid="monotonic">It falls all along: each voltage stands for one range.</p>`}`;
  }

  /** The curve with its clamped ends, and the pairs as dots: all on one axis of volts. */
  #curve(make: Plotter, host: HTMLElement, fit: Calibration): uPlot {
    const [low = NaN, high = NaN] = fit.domain;
    const within = (v: number): boolean => v >= low && v <= high;
    const line = (keep: (v: number) => boolean): (number | null)[] => [...fit.curveRanges].map((range, i) => (keep(fit.curveVolts[i] ?? NaN) ? range : null));
    const colour = colourOf(host, "map-estimate");
    return new make({
      ...this.frame(host, "V"),
      series: [{}, { stroke: colour, width: 1.6, spanGaps: true, points: { show: false } },
        { stroke: colour, width: 1.4, dash: [3, 3], points: { show: false } },
        { stroke: colourOf(host, "map-truth"), width: 0, paths: () => null, points: { show: true, size: 6, fill: colourOf(host, "map-truth") } }],
    }, make.join([[fit.curveVolts, line(within), line((v) => !within(v))], [fit.volts, fit.ranges]]), host);
  }

  #residuals(make: Plotter, host: HTMLElement, fit: Calibration): uPlot {
    const stroke = colourOf(host, "map-truth");
    return new make({
      ...this.frame(host, "m"),
      series: [{}, { stroke, width: 1, points: { show: true, size: 6, fill: stroke } }],
    }, [fit.ranges, fit.residuals.map((r) => 1000 * r)], host);
  }

  get #now(): Pairs {
    return this.#pairs ?? this.store.setup.calibration ?? { text: this.store.offer.dataSheet, variable: "per-volt" };
  }

  #toggle(event: Event): void {
    this.#open = (event.currentTarget as HTMLDetailsElement).open;
    if (this.#open) this.#change({});
  }

  #change(patch: Partial<Pairs>): void {
    this.#pairs = { ...this.#now, ...patch };
    this.client.send({ kind: "calibrate", pairs: this.#pairs });
    this.requestUpdate();
  }

  async #file(event: Event): Promise<void> {
    const [file] = filesOf(event);
    if (file) this.#change({ text: await file.text() });
  }

  /** Applying a calibration restarts the run: the rangers' electronics are part of the robot. */
  #apply(): void {
    this.client.start({ sensor: "rangers", calibration: this.#now, mode: "explore" });
  }
}

function pairsOf({ volts, ranges, residuals }: Calibration): Column[] {
  return [{ title: "Voltage", unit: "V", values: volts }, { title: "Range", unit: "m", values: ranges }, { title: "Curve less pair", unit: "m", values: residuals }];
}

function curveOf({ curveVolts, curveRanges }: Calibration): Column[] {
  return [{ title: "Voltage", unit: "V", values: curveVolts }, { title: "Range, curve", unit: "m", values: curveRanges }];
}

customElements.define("slam-calibration", SlamCalibration);
