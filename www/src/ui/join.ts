// A join of the pose graph that was chosen on the map: which submaps, how far they lie from it, and
// what it was made of.

import { css, html, nothing, type TemplateResult } from "lit";
import { degrees } from "../angle.js";
import { card } from "./card.js";
import { chi2Words, chi2Meaning } from "./chi2.js";
import { SlamElement } from "./element.js";
import { figure, figures } from "./figures.js";
import { fixed, length } from "./format.js";
import { icons } from "./icons.js";

const MATCHED = "Scans of the one are also in the other: the motion between the two was measured by matching.";
const LOOSE = "The scan that began the later one did not belong to the one before: the motion between the two is known by odometry or speed alone.";

export class SlamJoin extends SlamElement {
  static override styles = [
    figures,
    card,
    css`
      header svg { width: 28px; height: 10px; }
      .fate { font-size: 13px; font-weight: 600; }
    `,
  ];

  protected override readonly topics = ["frame", "join", "view", "run"] as const;

  override render(): TemplateResult | typeof nothing {
    const { store: { join, layers }, scene: { submaps } } = this;
    if (join === null || !layers.graph || join >= submaps.count) return nothing;
    const isLoose = submaps.isLoose(join);
    const [off, known] = [length(submaps.figure(join, "offShift")), length(submaps.figure(join, "joinShift"))];
    const chi2 = submaps.figure(join, "chi2");
    return html`<section aria-live="polite" aria-label="Join of the pose graph" data-testid="join">
      <header><svg viewBox="0 0 28 10" aria-hidden="true"><path d="M1 5h26" stroke="var(--map-ink)" stroke-width="3" stroke-dasharray=${isLoose ? "3 4" : "none"}/></svg>
        <b>Submap ${join - 1} to submap ${join}</b><span class="fate" data-testid="join-kind">${isLoose ? "Loose" : "Matched"}</span>
        <button class="icon" aria-label="Close" @click=${() => this.store.set("join", { join: null })}>${icons.close}</button></header>
      <p data-testid="join-why">${isLoose ? LOOSE : MATCHED}</p>
      ${Number.isNaN(chi2) ? html`<p>No motion was measured between them: a part of the way is missing.</p>` : html`<dl>
        ${figure("Off by now", `${off.value} ${off.unit}, ${fixed(degrees(submaps.figure(join, "offTurn")), 1)}°`, "join-off", "Between where the motion that was measured has the later submap and where it lies now: loop closures bend the way", "wide")}
        ${figure("Residual χ²", chi2Words(chi2), "join-chi2", chi2Meaning, "wide")}
        ${figure("Known to", `±${known.value} ${known.unit}, ${fixed(degrees(submaps.figure(join, "joinTurn")), 1)}°`, "join-known", "Standard deviation of the motion that was measured", "wide")}
      </dl>`}</section>`;
  }
}

customElements.define("slam-join", SlamJoin);
