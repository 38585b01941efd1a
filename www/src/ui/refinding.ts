// How well landmarks are found again in this run, against the truth known to the simulator: the
// receiver operating characteristic over the gate, and the rates at the gate in use.

import { css, nothing, type TemplateResult } from "lit";
import { REFINDING, REFINDING_STRIDE } from "../protocol/module.js";
import type { Column } from "../csv.js";
import type { Topic } from "../store.js";
import { html, svg } from "../words.js";
import { SlamElement } from "./element.js";
import "./csv_button.js";
import { fixed } from "./format.js";

const REDRAW_MILLIS = 500;

/** The counts at a gate; rates are 0 to 1, NaN without a count. */
export interface Gate {
  gate: number;
  tpr: number;
  fpr: number;
  ppv: number;
  acc: number;
  sightings: number;
}

const FIGURES: readonly { key: "tpr" | "fpr" | "ppv" | "acc"; label: string; meaning: string }[] = [
  { key: "tpr", label: "TPR", meaning: "True positive rate: of what was known before, the part that is found again as that." },
  { key: "fpr", label: "FPR", meaning: "False positive rate: of what is seen for the first time, the part that is taken for something known." },
  { key: "ppv", label: "PPV", meaning: "Positive predictive value: of what is found again, the part that is found rightly." },
  { key: "acc", label: "ACC", meaning: "Accuracy: of all that is seen, the part that is decided rightly." },
];

/** Possible ends of the axis of false positives, %. */
const ENDS = [1, 2, 5, 10, 20, 50, 100];

export class SlamRefinding extends SlamElement {
  static override styles = css`
    :host { margin-top: 14px; }
    h2 { margin-bottom: 4px; }
    p { margin: 0 0 6px; font-size: 12.5px; color: var(--muted); }
    dl { display: flex; flex-wrap: wrap; gap: 4px 14px; margin: 6px 0 0; font-size: 12.5px; }
    dl div { display: flex; gap: 5px; }
    dt { color: var(--muted); }
    dd { margin: 0; color: var(--ink); }
    figure { display: grid; grid-template: 150px auto / 40px 1fr; margin: 0; font: 500 11px/1 var(--mono); color: var(--muted); }
    figure > svg { width: 100%; height: 100%; overflow: visible; }
    .y, .x { display: flex; justify-content: space-between; }
    .y { flex-direction: column; text-align: right; padding-right: 6px; }
    .x { grid-column: 2; padding-top: 5px; }
    .frame { fill: none; stroke: var(--line); }
    .half { stroke: var(--line); }
    .curve { fill: none; stroke: var(--map-estimate); stroke-width: 1.8; vector-effect: non-scaling-stroke; }
    .gate { fill: var(--map-estimate); stroke: none; }
    .set { fill: var(--map-truth); stroke: var(--surface); stroke-width: 2; }
  `;

  protected override readonly topics: readonly Topic[] = ["run", "settings"];
  #drawnAt = -Infinity;
  #shown: Float32Array | null = null;

  override connectedCallback(): void {
    super.connectedCallback();
    this.store.on("frame", () => this.#feed());
  }

  override render(): TemplateResult {
    const gates = gatesOf(this.scene.refinding);
    const set = between(gates, this.#gate());
    this.toggleAttribute("hidden", !set);
    if (!set) return html`${nothing}`;
    return html`<h2>Found again</h2>
      <p>Lines and points of all scans so far against what they truly are, had the gate been smaller or larger. The large dot is the gate that is set.</p>
      ${this.#plot(gates, set)}
      <dl><div><dt>gate</dt><dd class="num" data-testid="refinding-gate">${fixed(set.gate, 2)}</dd></div>
        ${FIGURES.map(({ key, label, meaning }) => html`<div title=${meaning}><dt>${label}</dt><dd class="num" data-testid="refinding-${key}">${percent(set[key])}</dd></div>`)}
        <div title="Lines and points of all scans so far"><dt>of</dt><dd class="num">${set.sightings}</dd></div></dl>
      <slam-csv .name=${"found-again"} .columns=${() => columnsOf(gatesOf(this.scene.refinding))}></slam-csv>`;
  }

  #plot(gates: readonly Gate[], set: Gate): TemplateResult {
    const counted = gates.filter((g) => Number.isFinite(g.fpr) && Number.isFinite(g.tpr));
    const widest = 100 * Math.max(0, ...counted.map((g) => g.fpr));
    const end = ENDS.find((e) => e >= widest) ?? 100;
    const [x, y] = [(g: Gate): number => (1e4 * g.fpr) / end, (g: Gate): number => 100 - 100 * g.tpr];
    const dot = (g: Gate, radius: number, style: string): TemplateResult<2> | typeof nothing =>
      Number.isFinite(x(g)) && Number.isFinite(y(g)) ? svg`<circle class=${style} cx="${x(g)}%" cy="${y(g)}%" r=${radius}/>` : nothing;
    return html`<figure role="img" aria-label="True positive rate over false positive rate, gate by gate" data-testid="refinding" data-gates=${counted.length}>
      <div class="y"><span>100 %</span><span>TPR</span><span>0 %</span></div>
      <svg>
        <rect class="frame" width="100%" height="100%"/><line class="half" x1="0" x2="100%" y1="50%" y2="50%"/>
        <svg width="100%" height="100%" viewBox="0 0 100 100" preserveAspectRatio="none"><polyline class="curve" points="0,100 ${counted.map((g) => `${x(g)},${y(g)}`).join(" ")}"/></svg>
        ${counted.map((g) => dot(g, 2.2, "gate"))}${dot(set, 6, "set")}
      </svg>
      <div class="x"><span>0 %</span><span>FPR</span><span>${end} %</span></div>
    </figure>`;
  }

  /** The gate in use. */
  #gate(): number {
    const { setup, settings } = this.store;
    return setup.settings["ekf.gate"] ?? settings.find((s) => s.key === "ekf.gate")?.default ?? NaN;
  }

  /** Draws new data, if it is due. */
  #feed(): void {
    const now = performance.now();
    const { refinding } = this.scene;
    if (refinding === this.#shown || (this.store.playing && now - this.#drawnAt < REDRAW_MILLIS)) return;
    [this.#shown, this.#drawnAt] = [refinding, now];
    this.requestUpdate();
  }
}

function percent(part: number): string {
  return Number.isFinite(part) ? `${fixed(100 * part, 1)} %` : "–";
}

/** The rows of the module. */
export function gatesOf(rows: Float32Array): Gate[] {
  return Array.from({ length: rows.length / REFINDING_STRIDE }, (_, i) => {
    const at = (place: number): number => rows[i * REFINDING_STRIDE + place] ?? NaN;
    return { gate: at(REFINDING.gate), tpr: at(REFINDING.tpr), fpr: at(REFINDING.fpr), ppv: at(REFINDING.ppv), acc: at(REFINDING.acc), sightings: at(REFINDING.sightings) };
  });
}

/** The rates at a gate, interpolated between the neighbouring gates that were counted; a larger
    gate gets the rates of the last one. */
export function between(gates: readonly Gate[], gate: number): Gate | null {
  if (!Number.isFinite(gate)) return null;
  const next = gates.findIndex((g) => g.gate >= gate);
  const [low, high] = [gates[next < 0 ? gates.length - 1 : Math.max(next - 1, 0)], gates[next < 0 ? gates.length - 1 : next]];
  if (!low || !high) return null;
  const part = high.gate > low.gate ? Math.min(Math.max((gate - low.gate) / (high.gate - low.gate), 0), 1) : 0;
  const mix = (key: keyof Gate): number => low[key] + part * (high[key] - low[key]);
  return { gate, tpr: mix("tpr"), fpr: mix("fpr"), ppv: mix("ppv"), acc: mix("acc"), sightings: high.sightings };
}

function columnsOf(gates: readonly Gate[]): Column[] {
  const of = (title: string, key: keyof Gate): Column => ({ title, unit: "", values: gates.map((gate) => gate[key]) });
  return [of("Gate", "gate"), of("TPR", "tpr"), of("FPR", "fpr"), of("PPV", "ppv"), of("ACC", "acc"), of("Sightings", "sightings")];
}

customElements.define("slam-refinding", SlamRefinding);
