// The card of the experiment that is shown: what to watch.

import { nothing, type TemplateResult } from "lit";
import { isOf, type Shown } from "../gallery.js";
import { html } from "../words.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";
import { story } from "./story_card.js";

export class SlamExhibit extends SlamElement {
  static override styles = story;

  protected override readonly topics = ["exhibit", "tour"] as const;
  /** The experiment whose story was read: it is folded to its name, to make room for the map. */
  #folded: Shown | null = null;

  override connectedCallback(): void {
    super.connectedCallback();
    // Another run has another story.
    this.store.on("run", () => {
      const { exhibit } = this.store;
      if (exhibit && !isOf(exhibit, this.store)) this.store.set("exhibit", { exhibit: null });
    });
  }

  override render(): TemplateResult | typeof nothing {
    const { exhibit, tour } = this.store;
    if (!exhibit || tour) return nothing;
    const isFolded = this.#folded === exhibit;
    return html`<section aria-label="What to watch" data-testid="exhibit">
      <header><h2>${exhibit.title}</h2>
        <button class="icon" data-testid="fold-exhibit" aria-expanded=${!isFolded} aria-label=${isFolded ? "Read what to watch" : "Show the name only"} title=${isFolded ? "Read what to watch" : "Show the name only"}
          @click=${this.press(() => this.#fold(isFolded ? null : exhibit))}>${isFolded ? icons.plus : icons.minus}</button>
        <button class="icon" aria-label="Close" @click=${this.press(() => this.store.set("exhibit", { exhibit: null }))}>${icons.close}</button></header>
      ${isFolded ? nothing : html`<p>${exhibit.watch}</p>`}
      ${exhibit.kidnaps ? html`<p><button data-testid="kidnap-here" title="Carry the robot to a random place, without telling it" @click=${this.press(() => this.client.kidnap())}>${icons.hand} Kidnap</button></p>` : nothing}
      ${isFolded ? nothing : html`<p class="muted">${exhibit.then}</p>`}
    </section>`;
  }

  #fold(exhibit: Shown | null): void {
    this.#folded = exhibit;
    this.requestUpdate();
  }
}

customElements.define("slam-exhibit", SlamExhibit);
