// What the map is worth: whether it agrees with itself, and where not and why.

import { css, html, nothing, type TemplateResult } from "lit";
import type { MapVerdictName, Quality, Tear, UnjudgeableName } from "../protocol/module.js";
import { SlamElement } from "./element.js";
import { fixed, percent } from "./format.js";
import { apart, seen, WHY } from "./tears.js";

const VERDICTS: Readonly<Record<MapVerdictName, string>> = {
  good: "Wherever a place was seen again, both agree.",
  doubtful: "Nothing contradicts, but parts of it may lie elsewhere.",
  torn: "This map is torn.",
};

/** Why nothing can be said. */
const NOTHING_SAID: Readonly<Record<UnjudgeableName, string>> = {
  "no-surfaces": "No scan showed a surface that others could be matched to: nothing can be said of this map, nor of where the robot was.",
  "one-scan": "There is one scan: nothing can be said of this map yet.",
  unmatched: "Only the first scan was drawn, and the last could not be matched to it: nothing can be said of this map, nor of where the robot was.",
};

/** The worst places, told in words. */
const MOST_TOLD = 8;

export class SlamQuality extends SlamElement {
  static override styles = css`
    h2 { margin: 18px 0 8px; }
    p { margin: 0 0 8px; font-size: 12.5px; color: var(--muted); }
    p.torn { color: var(--danger); font-weight: 600; }
    ol { margin: 0 0 10px; padding: 0 0 0 20px; font-size: 12.5px; }
    li { margin-bottom: 5px; }
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

  #judged({ verdict, unjudgeable, agreement, tears }: Quality): TemplateResult {
    if (unjudgeable && tears.length === 0) return html`<p class=${verdict} data-testid="quality">${NOTHING_SAID[unjudgeable]}</p>`;
    return html`
      <p class=${verdict} data-testid="quality">${VERDICTS[verdict]}
        ${agreement === null ? "No place was seen twice yet." : `${fixed(100 * agreement, 0)} % of what was seen again agrees.`}</p>
      ${tears.length > 0 ? html`<ol data-testid="tears">${tears.slice(0, MOST_TOLD).map((tear) => this.#item(tear))}</ol>` : nothing}
      ${tears.length > MOST_TOLD ? html`<p>${tears.length - MOST_TOLD} more are marked in the map.</p>` : nothing}
    `;
  }

  #item(tear: Tear): TemplateResult {
    const { kind, place: [x, y], earlier, later } = tear;
    const off = apart(tear);
    return html`<li>At (${fixed(x, 1)}, ${fixed(y, 1)}) m: ${WHY[kind]}${off === "" ? "" : `, ${off}`}; seen ${seen(earlier)} and ${seen(later)}.</li>`;
  }
}

customElements.define("slam-quality", SlamQuality);
