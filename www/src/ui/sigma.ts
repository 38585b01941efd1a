// The range noise of this sensor, estimated from scans of a robot that stands; and its use.

import { css, type TemplateResult } from "lit";
import type uPlot from "uplot";
import type { Column } from "../csv.js";
import type { GrowthName, SigmaCurve } from "../protocol/module.js";
import { html, t } from "../words.js";
import "./csv_button.js";
import { fixed } from "./format.js";
import { valueOf } from "./input.js";
import { colourOf } from "./plot_style.js";
import { type Plotter, SlamPlotted } from "./plotted.js";
import { tool } from "./style.js";

export class SlamSigma extends SlamPlotted {
  static override styles = [
    tool,
    css`
      .row { display: flex; gap: 8px; margin: 8px 0; }
      .row > * { flex: 1; }
    `,
  ];

  protected override readonly topics = ["sigma", "settings", "run", "theme"] as const;
  protected override readonly height = 150;
  #growth: GrowthName = "linear";

  override render(): TemplateResult {
    const { store } = this;
    const { curve, error } = store.sigma;
    const { settings } = store.setup;
    const inUse = curve !== null && settings["points.sigma_slope"] === curve.slope && settings["points.sigma_constant"] === curve.constant;
    return html`<details data-testid="sigma">
      <summary>Measure how much the ranges err</summary>
      <p>${store.source === "replay"
        ? "Two readings of one beam, one scan after the other, differ by √2 σ where the robot stands. The stretches of this recording in which it stood are compared."
        : "Two readings of one beam, one scan after the other, differ by √2 σ where the robot stands. A twin of this robot stands where it is now and scans 120 times."}</p>
      <div class="row">
        <select data-testid="growth" aria-label="How σ grows" @change=${(e: Event) => { this.#growth = valueOf(e) as GrowthName; this.requestUpdate(); }}>
          <option value="linear" .selected=${this.#growth === "linear"}>σ = a + b ρ</option>
          <option value="square" .selected=${this.#growth === "square"}>σ = a + b ρ²</option>
        </select>
        <button data-testid="estimate-sigma" @click=${() => this.client.send({ kind: "sigma", growth: this.#growth })}>Estimate</button>
      </div>
      <div aria-live="polite">${error ? html`<p class="bad" role="alert" data-testid="sigma-error">It cannot be estimated: ${error}</p>` : curve ? this.#words(curve) : ""}</div>
      <figure aria-label="σ over range: what was measured in each bin, and the curve" ?hidden=${!curve || error !== ""}><figcaption><span>σ over range, mm</span>${curve && curve.truth.length > 0 ? html`<span class="muted">dotted: as the noise was drawn</span>` : ""}</figcaption><div class="plot"></div></figure>
      ${curve && !error ? html`<slam-csv .name=${"sigma-measured"} .columns=${() => measuredOf(curve)}></slam-csv> <slam-csv .name=${"sigma-curve"} .columns=${() => curveOf(curve)}></slam-csv>` : ""}
      ${curve && !error ? html`<button class="apply" data-testid="use-sigma" ?disabled=${inUse} @click=${() => this.#use(curve)}>${inUse ? "In use" : store.source === "replay" ? "Map the recording with it" : "Use it instead of what the sensor says"}</button>` : ""}
    </details>`;
  }

  protected override draw(make: Plotter): uPlot[] {
    const { curve } = this.store.sigma;
    const host = this.renderRoot.querySelector<HTMLElement>(".plot");
    if (!curve || !host || this.clientWidth === 0) return [];
    const millimetres = (metres: Float64Array): Float64Array => metres.map((m) => 1000 * m);
    const bins: uPlot.AlignedData = [curve.bins.map((bin) => bin.range), curve.bins.map((bin) => 1000 * bin.sigma)];
    const [estimate, truth] = [colourOf(host, "map-estimate"), colourOf(host, "map-truth")];
    return [new make({
      ...this.frame(host, "m"),
      series: [{}, { stroke: estimate, width: 1.6, spanGaps: true, points: { show: false } }, { stroke: truth, width: 1.6, dash: [1, 3], spanGaps: true, points: { show: false } },
        { stroke: estimate, width: 0, paths: () => null, points: { show: true, size: 5, fill: estimate } }],
    }, make.join([[curve.curveRanges, millimetres(curve.curveSigmas), millimetres(curve.truth)], bins]), host)];
  }

  #words(curve: SigmaCurve): TemplateResult {
    const { constant: a, slope: b, constantError: da, slopeError: db, chiSquared: chi, freedom } = curve;
    const unit = curve.growth === "linear" ? "mm/m" : "mm/m²";
    // Three standard deviations above the mean of χ²: the form of the curve is wrong.
    const misfits = chi > freedom + 3 * Math.sqrt(2 * freedom);
    return html`<p data-testid="sigma-words">a = <b class="num">${fixed(1000 * a, 2)} ± ${fixed(1000 * da, 2)} mm</b>, b = <b class="num">${fixed(1000 * b, 2)} ± ${fixed(1000 * db, 2)} ${unit}</b>, from ${curve.scans} scans${curve.stretches > 1 ? t` in ${curve.stretches} stretches` : ""}.
      ${misfits ? t`The bins do not all lie on such a curve (χ² ${fixed(chi, 0)} with ${freedom} degrees of freedom): beams on edges and slanting walls spoil some, or the other form fits better.` : t`The bins lie on it as well as they can (χ² ${fixed(chi, 0)} with ${freedom} degrees of freedom).`}</p>`;
  }

  #use(curve: SigmaCurve): void {
    const { constant, slope, least } = curve;
    const { settings } = this.store.setup;
    this.client.configure({ ...settings, "points.sigma": curve.growth === "linear" ? 1 : 2, "points.sigma_constant": constant, "points.sigma_slope": slope, "points.sigma_least": least });
    if (this.store.source === "replay") this.client.again();
  }
}

/** The measured noise, bin by bin. */
function measuredOf({ bins }: SigmaCurve): Column[] {
  return [{ title: "Range", unit: "m", values: bins.map(({ range }) => range) }, { title: "σ", unit: "m", values: bins.map(({ sigma }) => sigma) }];
}

/** The fitted curve, and the true noise if it is known. */
function curveOf({ curveRanges, curveSigmas, truth }: SigmaCurve): Column[] {
  const known: Column[] = truth.length > 0 ? [{ title: "σ, as drawn", unit: "m", values: truth }] : [];
  return [{ title: "Range", unit: "m", values: curveRanges }, { title: "σ, curve", unit: "m", values: curveSigmas }, ...known];
}

customElements.define("slam-sigma", SlamSigma);
