// A place where the map is torn that was chosen on the map: why, by how much, and when its two
// sides were seen.

import { css, html, nothing, svg, type TemplateResult } from "lit";
import type { Tear, TearName } from "../protocol/module.js";
import { card } from "./card.js";
import { SlamElement } from "./element.js";
import { figure, figures } from "./figures.js";
import { fixed, length } from "./format.js";
import { icons } from "./icons.js";
import { seen } from "./tears.js";

const TITLES: Readonly<Record<TearName, string>> = {
  doubled: "The same walls stand twice",
  contradicted: "Walls where nothing was before",
  loose: "The robot was lost in between",
  unproven: "Nothing proves the way between",
};

/** What it means, and what may be done. */
const MEANS: Readonly<Record<TearName, string>> = {
  doubled: "What was seen at one time would agree with what was seen at the other if it lay elsewhere: a loop that should join the two is missing, or a wrong one pulls them apart.",
  contradicted: "At one time the robot saw through what stands there by the other, and nothing nearby fits: the two parts may be different places, laid on one another.",
  loose: "The way between the two was not measured surely, and no loop holds them together: the later part lies about where it is drawn.",
  unproven: "The way between was measured, but it was long and no loop holds its ends together. This alone does not mean that anything is wrong.",
};

export class SlamTorn extends SlamElement {
  static override styles = [
    figures,
    card,
    css`header svg { width: 20px; height: 20px; }`,
  ];

  protected override readonly topics = ["quality", "torn", "view", "run"] as const;

  override render(): TemplateResult | typeof nothing {
    const { torn, layers } = this.store;
    return torn && layers.torn ? this.#place(torn) : nothing;
  }

  #place({ kind, place: [x, y], off, earlier, later, witnesses }: Tear): TemplateResult {
    const measured = off === null ? null : length(off);
    const how = kind === "doubled" ? "Walls apart by" : "Known to";
    return html`<section aria-live="polite" aria-label="Torn place" data-testid="torn">
      <header><svg viewBox="0 0 20 20" aria-hidden="true" fill="none" stroke-width="2"><circle cx="10" cy="10" r="8" stroke="var(--map-torn)" stroke-dasharray=${kind === "unproven" ? "3 3" : "none"}/>${kind === "unproven" ? nothing : svg`<path d="M7 7l6 6M13 7l-6 6" stroke="var(--map-torn)"/>`}</svg>
        <b data-testid="torn-why">${TITLES[kind]}</b>
        <button class="icon" aria-label="Close" @click=${() => this.store.set("torn", { torn: null })}>${icons.close}</button></header>
      <p>${MEANS[kind]}</p>
      <dl>
        ${measured ? figure(how, `${kind === "doubled" ? "" : "±"}${measured.value} ${measured.unit}`, "torn-off", "As measured between walls that stand twice, or one standard deviation of what is not known", "wide") : figure("Apart by", "too far to tell", "torn-off", "Nothing fits nearby", "wide")}
        ${figure("Seen first", seen(earlier), "torn-earlier", "Time of the run in which the one side was seen", "wide")}
        ${figure("Seen again", seen(later), "torn-later", "Time of the run in which the other side was seen", "wide")}
        ${figure("Where", `${fixed(x, 1)}, ${fixed(y, 1)} m`, "torn-where", "In the map", "wide")}
        ${witnesses > 0 ? figure("Pairs of submaps that say so", `${witnesses}`, "torn-witnesses", "One alone may be furniture that was moved; it is heard only where scans that two submaps share were shifted", "wide") : nothing}
      </dl></section>`;
  }
}

customElements.define("slam-torn", SlamTorn);
