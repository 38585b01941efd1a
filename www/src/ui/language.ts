// In which language the page speaks: each by its own name.

import { css, type TemplateResult } from "lit";
import { choose } from "../language.js";
import { type Language, language, LANGUAGES } from "../spoken.js";
import { html, t } from "../words.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";
import { valueOf } from "./input.js";

export class SlamLanguage extends SlamElement {
  static override styles = css`
    label { display: flex; align-items: center; gap: 8px; max-width: 280px; }
    select { flex: 1; }
  `;

  override render(): TemplateResult {
    return html`<label>${icons.globe} <span>Language</span>
      <select data-testid="language" @change=${(e: Event) => void this.#choose(valueOf(e) as Language)}>
        ${Object.entries(LANGUAGES).map(([code, name]) => html`<option value=${code} lang=${code} .selected=${code === language()}>${name}</option>`)}
      </select></label>`;
  }

  async #choose(wanted: Language): Promise<void> {
    try {
      await choose(wanted);
    } catch {
      this.store.set("toast", { toast: { level: "warn", text: t`${LANGUAGES[wanted]} could not be loaded. Is the server still there?` } });
      this.requestUpdate();
    }
  }
}

customElements.define("slam-language", SlamLanguage);
