// The judgement of the map: whether it agrees with itself, and if not, where and why.

import { css, nothing, type TemplateResult } from "lit";
import { degrees } from "../angle.js";
import type { MapVerdictName, Quality, Tear, UnjudgeableName } from "../protocol/module.js";
import { html, svg, t } from "../words.js";
import { SlamElement } from "./element.js";
import { fixed, percent } from "./format.js";
import { apart, seen, WHY } from "./tears.js";

const VERDICTS: Readonly<Record<MapVerdictName, string>> = {
  good: "Wherever a place was seen again, both agree.",
  doubtful: "Nothing contradicts, but parts of it may lie elsewhere.",
  torn: "This map is torn.",
};

/** Why no judgement is possible. */
const NOTHING_SAID: Readonly<Record<UnjudgeableName, string>> = {
  "no-surfaces": "No scan showed a surface that others could be matched to: nothing can be said of this map, nor of where the robot was.",
  "one-scan": "There is one scan: nothing can be said of this map yet.",
  unmatched: "Only the first scan was drawn, and the last could not be matched to it: nothing can be said of this map, nor of where the robot was.",
};

/** Number of the worst places that are described in words. */
const MOST_TOLD = 8;

export class SlamQuality extends SlamElement {
  static override styles = css`
    h2 { margin: 18px 0 8px; }
    p { margin: 0 0 8px; font-size: 12.5px; color: var(--muted); }
    p.torn { color: var(--danger); font-weight: 600; }
    ol { margin: 0 0 10px; padding: 0 0 0 20px; font-size: 12.5px; }
    li { margin-bottom: 5px; }
    svg.loops { display: block; width: 100%; height: auto; margin-bottom: 4px; stroke-width: 1; }
    .loops circle { fill: var(--map-accepted); stroke: none; }
    .loops .line { stroke: var(--line); }
    .loops .most { stroke: var(--muted); stroke-dasharray: 4 3; }
    .loops text { font-size: 8px; fill: var(--muted); stroke: none; text-anchor: end; }
  `;

  protected override readonly topics = ["quality", "run"] as const;

  override render(): TemplateResult {
    const { quality, judging, method } = this.store;
    if (method !== "scan-matching") return html`
      <h2>Quality of the map</h2>
      <p data-testid="quality">Not judged: only the map of scan matching is.</p>
    `;
    return html`
      <h2>Quality of the map</h2>
      ${quality ? this.#judged(quality) : html`<p>It is judged while a recording is mapped and when it ends, or now.</p>`}
      <button data-testid="judge" ?disabled=${judging !== null} @click=${() => this.client.send({ kind: "quality" })}>${judging === null ? "Judge the map" : html`Judging … ${percent(judging)}`}</button>
    `;
  }

  #judged(quality: Quality): TemplateResult {
    const { verdict, unjudgeable, agreement, tears } = quality;
    if (unjudgeable && tears.length === 0) return html`<p class=${verdict} data-testid="quality">${NOTHING_SAID[unjudgeable]}</p>`;
    return html`
      <p class=${verdict} data-testid="quality">${VERDICTS[verdict]}
        ${agreement === null ? "No place was seen twice yet." : t`${fixed(100 * agreement, 0)} % of what was seen again agrees.`}</p>
      ${tears.length > 0 ? html`<ol data-testid="tears">${tears.slice(0, MOST_TOLD).map((tear) => this.#item(tear))}</ol>` : nothing}
      ${tears.length > MOST_TOLD ? html`<p>${tears.length - MOST_TOLD} more are marked in the map.</p>` : nothing}
      ${this.#loops(quality)}
    `;
  }

  /** The errors of the trajectory corrected by loop closures, over time. */
  #loops({ loops, loopRatio, isOverconfident }: Quality): TemplateResult | typeof nothing {
    if (loops.length === 0) return nothing;
    const [first, last] = [loops[0]?.at ?? 0, loops.at(-1)?.at ?? 0];
    const x = (at: number): number => 6 + (288 * (at - first)) / Math.max(last - first, 1);
    // Logarithmic: from a tenth at the bottom to ten times at the top.
    const y = (ratio: number): number => 30 - 26 * Math.log10(Math.min(Math.max(ratio, 0.1), 10));
    return html`
      <p class=${isOverconfident ? "torn" : ""} data-testid="loops">Loops were closed from ${loops.length === 1 ? "one stretch" : t`${loops.length} stretches`} of the way.
        ${loopRatio === null ? nothing : html`The ways round were off by ${fixed(loopRatio, loopRatio < 1 ? 2 : 1)} times what was known of them, on the median: they are known ${isOverconfident ? "worse than is said." : "about as well as is said, or better."}`}</p>
      <svg data-testid="loop-plot" class="loops" viewBox="0 -8 300 72" role="img" aria-label="How far off the way of each loop was, in units of what was known of it, over time">
        ${[0.1, 1, 3, 10].map((ratio) => svg`<path d="M0 ${y(ratio)}h300" class=${ratio === 3 ? "most" : "line"}/><text x="300" y=${y(ratio) - 2}>${ratio === 0.1 ? "≤ 0.1" : ratio === 10 ? "≥ 10" : ratio}</text>`)}
        ${loops.map(({ at, ratio, doubt, found }) => svg`<circle cx=${x(at)} cy=${y(ratio)} r="2.4"><title>At ${fixed(at, 0)} s: off by ${fixed(found[0], 2)} m and ${fixed(degrees(found[1]), 1)}°, known to ${fixed(doubt[0], 2)} m and ${fixed(degrees(doubt[1]), 1)}°</title></circle>`)}
      </svg>
      <p>Over time, how far the way round was off when each loop was closed, in units of what was known of it. 1 is as was said; above the dashed line it was known badly.</p>
    `;
  }

  #item(tear: Tear): TemplateResult {
    const { kind, place: [x, y], earlier, later } = tear;
    const off = apart(tear);
    return html`<li>At (${fixed(x, 1)}, ${fixed(y, 1)}) m: ${WHY[kind]}${off === "" ? "" : `, ${off}`}; seen ${seen(earlier)} and ${seen(later)}.</li>`;
  }
}

customElements.define("slam-quality", SlamQuality);
