// A loop closure that was chosen on the map: which submaps, how far they lie from where it has
// them, and why it was accepted or not.

import { css, html, nothing, type TemplateResult } from "lit";
import { degrees } from "../angle.js";
import { CLOSURE, CLOSURE_STRIDE } from "../protocol/module.js";
import { CLOSURE_PENS, rowOf } from "../view/layers/closures.js";
import { FATE, type Fate } from "../view/submaps.js";
import { card } from "./card.js";
import { chi2Meaning, chi2Words } from "./chi2.js";
import { type Figures, WHY } from "./closure_words.js";
import { SlamElement } from "./element.js";
import { figure, figures } from "./figures.js";
import { fixed, length, percent } from "./format.js";
import { icons } from "./icons.js";

const FATES: Readonly<Record<Fate, string>> = { accepted: "Accepted", waiting: "Waits", refused: "Refused", revoked: "Revoked" };

export class SlamClosure extends SlamElement {
  static override styles = [
    figures,
    card,
    css`
      header svg { width: 28px; height: 10px; }
      .fate { font-size: 13px; font-weight: 600; }
    `,
  ];

  protected override readonly topics = ["frame", "closure", "view", "run"] as const;

  override render(): TemplateResult | typeof nothing {
    const { store, scene: { submaps } } = this;
    const row = store.closure && store.layers.closures ? rowOf(submaps, store.closure) : null;
    const outcome = row === null ? undefined : submaps.outcomes[row];
    if (row === null || !outcome) return nothing;
    const at = (place: number): number => submaps.closures[row * CLOSURE_STRIDE + place] ?? NaN;
    const f = Object.fromEntries(Object.entries(CLOSURE).map(([name, place]) => [name, at(place)])) as unknown as Figures;
    const [off, doubt] = [length(f.offShift), length(f.doubtShift)];
    const fate = FATE[outcome];
    return html`<section aria-live="polite" aria-label="Loop closure" data-testid="closure">
      <header><svg viewBox="0 0 28 10" aria-hidden="true"><path d="M1 5h26" stroke="var(--map-${fate})" stroke-width="3" stroke-dasharray=${(CLOSURE_PENS[fate].dash ?? []).join(" ")}/></svg>
        <b>Submap ${f.new} in submap ${f.old}</b><span class="fate" data-testid="closure-fate">${FATES[fate]}</span>
        <button class="icon" aria-label="Close" @click=${() => store.set("closure", { closure: null })}>${icons.close}</button></header>
      <p data-testid="closure-why">${WHY[outcome](f)}</p>
      <dl>
        ${figure("Off by now", `${off.value} ${off.unit}, ${fixed(degrees(f.offTurn), 1)}°`, "closure-off", "Between the place that was found and where the two submaps lie now", "wide")}
        ${figure("Residual χ²", chi2Words(f.chi2), "closure-chi2", chi2Meaning, "wide")}
        ${figure("Known before to", `±${doubt.value} ${doubt.unit}, ${fixed(degrees(f.doubtTurn), 1)}°`, "closure-doubt", "Standard deviation of the place before the two were compared", "wide")}
        ${figure("Overlap", percent(f.overlap), "closure-overlap", "How much of the smaller submap lies on the other")}
        ${figure("Agrees", percent(f.part), "closure-part", "Of what both could see, the part that is the same")}
      </dl></section>`;
  }
}

customElements.define("slam-closure", SlamClosure);
