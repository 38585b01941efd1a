// The consistency of the filter: its two figures with their bands, and a sentence that names the
// likely cause if they leave them.

import { css, nothing, type TemplateResult } from "lit";
import { degrees } from "../angle.js";
import type { DiagnosisName } from "../protocol/module.js";
import { SAMPLE } from "../protocol/sample.js";
import { html } from "../words.js";
import { type Curve, SlamCharts } from "./charts.js";
import { fixed } from "./format.js";

interface Words {
  level: "good" | "warn" | "plain";
  verdict: string;
  why: string;
}

const WORDS: Readonly<Record<DiagnosisName, Words>> = {
  collecting: { level: "plain", verdict: "Too early to judge", why: "The filter is judged over 25 scans." },
  blind: { level: "warn", verdict: "No wall was recognised lately", why: "The estimate lives on the wheels alone; its ellipse grows until a known wall comes into sight." },
  honest: { level: "good", verdict: "Honest", why: "Errors are as large as the filter claims." },
  "wrong-match": { level: "warn", verdict: "Overconfident: likely a wrong match, or slip", why: "The pose is further off than claimed, and the walls are not where they are expected. One wall was taken for another, or the tracks slipped more than the odometry's noise allows." },
  "hidden-drift": { level: "warn", verdict: "Overconfident: likely a drift that no wall shows", why: "The pose is further off than claimed, yet the walls are where they are expected: the map has turned with the robot. That comes from linearisation, or from wheels that err the same way all the time." },
  "noisy-sightings": { level: "warn", verdict: "Sightings err more than claimed", why: "The walls are not where they are expected. The sensor is noisier than assumed, the walls are not flat, or something moves." },
  cautious: { level: "plain", verdict: "Cautious", why: "Errors are smaller than the filter claims: it assumes more noise than there is." },
};

export class SlamConsistency extends SlamCharts {
  static override styles = [
    SlamCharts.styles,
    css`
      .verdict { padding: 10px 12px; margin: 0 0 12px; border-radius: 12px; background: var(--sunk); border: 1px solid var(--line); border-left: 5px solid var(--line-strong); }
      .verdict.good { border-left-color: var(--good); }
      .verdict.warn { border-left-color: var(--warn); }
      .learned { margin: 0 0 12px; font-size: 12.5px; color: var(--muted); }
      .learned b { font-weight: 500; color: var(--ink); white-space: nowrap; }
      .verdict b { display: block; font-weight: 600; }
      .verdict span { font-size: 12.5px; color: var(--muted); }
    `,
  ];

  protected override readonly topics = ["theme", "run", "frame", "inspection"] as const;
  protected override readonly curves: readonly Curve[] = [
    { title: "NEES", meaning: "Normalised estimation error squared of the pose, mean of 25 scans: 3 is honest. Needs the truth, so only a simulation has it.", unit: "",
      value: SAMPLE.nees, bounds: [SAMPLE.neesHigh, SAMPLE.neesLow], key: "95 % of χ²", digits: 2, colour: "estimate" },
    { title: "NIS", meaning: "Normalised innovation squared for each degree of freedom, over 25 scans: 1 is honest. Needs no truth.", unit: "",
      value: SAMPLE.nis, bounds: [SAMPLE.nisHigh, SAMPLE.nisLow], key: "95 % of χ²", digits: 2, colour: "truth" },
  ];

  override render(): TemplateResult {
    const { status, method } = this.store;
    if (method !== "line-ekf") {
      return html`<h2>Filter</h2><p class="muted" data-testid="no-filter">Scan matching keeps no common covariance of pose and walls: there is no filter to look into. Choose the method Line EKF-SLAM.</p>`;
    }
    const words = WORDS[status?.diagnosis ?? "collecting"];
    return html`<h2>Is the filter honest?</h2>
      <p class="verdict ${words.level}" data-testid="diagnosis"><b>${words.verdict}</b><span>${words.why}</span></p>
      ${this.#learned()}
      ${super.render()}`;
  }

  /** What the walls taught the filter about its odometry. */
  #learned(): TemplateResult | typeof nothing {
    const { inspection } = this.store;
    if (!inspection) return nothing;
    const { curvature: bend, turnScale: stretch, curvatureSigma, turnScaleSigma } = inspection.odometry;
    return html`<p class="learned" data-testid="learned">Learned of its tracks: a straight drive bends by
      <b class="num">${fixed(degrees(Math.abs(bend)), 2)} ± ${fixed(degrees(curvatureSigma), 2)} °/m</b> to the ${bend < 0 ? "right" : "left"}, a turn is
      <b class="num">${fixed(100 * Math.abs(stretch), 1)} ± ${fixed(100 * turnScaleSigma, 1)} %</b> ${stretch < 0 ? "smaller" : "larger"} than they say.</p>`;
  }
}

customElements.define("slam-consistency", SlamConsistency);
