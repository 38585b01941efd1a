// Reports that a newer build of the page exists, and offers it. The run ends only if somebody
// accepts.

import { css, nothing, type TemplateResult } from "lit";
import { renew, type Renewal } from "../offline.js";
import { html } from "../words.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";

const WORDS: Readonly<Record<Exclude<Renewal, null>, string>> = {
  waits: "A newer version of this page is here.",
  "took over": "A newer version of this page was taken in another window: this one is of before.",
};

export class SlamRenewal extends SlamElement {
  static override styles = css`
    :host { position: fixed; left: 50%; top: 64px; transform: translateX(-50%); z-index: 30; width: max-content; max-width: calc(100vw - 24px); pointer-events: none; }
    div { pointer-events: auto; display: flex; flex-wrap: wrap; align-items: center; gap: 4px 10px; padding: 6px 6px 6px 14px; border-radius: 14px; background: var(--raised); border: 1px solid var(--good); box-shadow: var(--shadow); font-size: 13.5px; }
    .icon { border-color: transparent; background: transparent; }
  `;

  protected override readonly topics = ["offline"] as const;
  /** The renewal that somebody closed. */
  #dismissed: Renewal = null;

  override render(): TemplateResult {
    const { renewal } = this.store;
    return html`<span role="status">${renewal && renewal !== this.#dismissed
      ? html`<div data-testid="renewal"><span>${WORDS[renewal]}</span>
          <button data-testid="renew" title="Load it; the run that is shown ends" @click=${() => this.#renew()}>${icons.again} Reload</button>
          <button class="icon" aria-label="Later" title="Later: it is offered again when the page is loaded next" @click=${() => this.#dismiss(renewal)}>${icons.close}</button></div>`
      : nothing}</span>`;
  }

  #renew(): void {
    // No robot may go on driving without its driver.
    if (this.client.robot.mayBeDriven) this.client.stop();
    renew();
  }

  #dismiss(renewal: Renewal): void {
    this.#dismissed = renewal;
    this.requestUpdate();
  }
}

customElements.define("slam-renewal", SlamRenewal);
