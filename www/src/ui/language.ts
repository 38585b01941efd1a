// The chooser of the page's language; each is listed by its own name. A bundle of its own, because
// a first visit does not need it.

import { css, type TemplateResult } from "lit";
import { KEPT, load, PARAMETER } from "../language.js";
import { type Language, language, LANGUAGE_CHANGED, LANGUAGES } from "../spoken.js";
import { ifAllowed } from "../storage.js";
import { html, svg, t } from "../words.js";
import { SlamElement } from "./element.js";
import { valueOf } from "./input.js";

const GLOBE = svg`<svg viewBox="0 0 24 24" aria-hidden="true"><circle cx="12" cy="12" r="9"/><path d="M3 12h18M12 3c2.6 2.5 4 5.5 4 9s-1.4 6.5-4 9c-2.6-2.5-4-5.5-4-9s1.4-6.5 4-9"/></svg>`;

export class SlamLanguage extends SlamElement {
  static override styles = css`
    label { display: flex; align-items: center; gap: 8px; max-width: 280px; }
    select { flex: 1; }
  `;

  override render(): TemplateResult {
    return html`<label>${GLOBE} <span>Language</span>
      <select data-testid="language" @change=${(e: Event) => void this.#choose(valueOf(e) as Language)}>
        ${Object.entries(LANGUAGES).map(([code, name]) => html`<option value=${code} lang=${code} .selected=${code === language()}>${name}</option>`)}
      </select></label>`;
  }

  /** Switches to a language, and remembers it. */
  async #choose(wanted: Language): Promise<void> {
    try {
      await load(wanted);
      ifAllowed(() => localStorage.setItem(KEPT, wanted));
      // The choice replaces the language of the link that opened the page.
      const url = new URL(location.href);
      url.searchParams.delete(PARAMETER);
      if (url.href !== location.href) history.replaceState(history.state, "", url);
      dispatchEvent(new Event(LANGUAGE_CHANGED));
    } catch {
      this.store.set("toast", { toast: { level: "warn", text: t`${LANGUAGES[wanted]} could not be loaded. Is the server still there?` } });
      this.requestUpdate();
    }
  }
}

customElements.define("slam-language", SlamLanguage);
