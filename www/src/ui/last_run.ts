// Offers the run that was left on the last visit.

import { css, nothing, type TemplateResult } from "lit";
import { goOn, shownTitle } from "../last_run.js";
import { html, t } from "../words.js";
import { SlamElement } from "./element.js";
import { clock } from "./format.js";
import { icons } from "./icons.js";
import { story } from "./story_card.js";

export class SlamLastRun extends SlamElement {
  static override styles = [story, css`
    section { width: 300px; }
    h2 { font-size: 15px; }
    .row { display: flex; gap: 8px; }
    .next { background: var(--accent); color: var(--on-accent); border-color: transparent; }
    .next:hover { background: var(--accent-ink); border-color: transparent; }
  `];

  protected override readonly topics = ["last", "tour", "run"] as const;

  override render(): TemplateResult | typeof nothing {
    const { lastRun: last, tour, offer: { methods } } = this.store;
    if (!last || tour) return nothing;
    const method = methods.find(({ name }) => name === last.method)?.title ?? last.method;
    const title = shownTitle(last);
    const from = last.kind === "sim" && last.link !== null ? t`It is done again as far as ${clock(last.time)}, and waits there.` : "It begins again from its beginning.";
    return html`<section aria-label="Your last run" data-testid="last-run">
      <header><h2>Go on where you left off?</h2>
        <button class="icon" aria-label="Forget it" @click=${this.press(() => this.store.set("last", { lastRun: null }))}>${icons.close}</button></header>
      <p><b>${title}</b>, ${method}, at ${clock(last.time)}. <span class="muted">${from}</span></p>
      <div class="row"><button class="next" data-testid="go-on" @click=${this.press(() => void goOn(this.store, this.client))}>Go on</button></div>
    </section>`;
  }
}

customElements.define("slam-last-run", SlamLastRun);
