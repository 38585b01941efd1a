// Reports for some seconds that a loop was closed, and how far that moved the map.

import { css, type TemplateResult } from "lit";
import { html, t } from "../words.js";
import { SlamElement } from "./element.js";
import { fixed } from "./format.js";

const SHOWN_MILLIS = 4000;

export class SlamMoved extends SlamElement {
  static override styles = css`
    :host { position: absolute; left: 50%; top: 14px; transform: translateX(-50%); pointer-events: none; z-index: 1; }
    div { padding: 8px 14px; border-radius: 22px; width: max-content; max-width: calc(100vw - 130px); line-height: 1.3; font-size: 13.5px; background: var(--ink); color: var(--surface); box-shadow: var(--shadow); animation: in .25s ease-out; }
    @keyframes in { from { opacity: 0; transform: translateY(-6px); } }
  `;

  protected override readonly topics = ["moved"] as const;
  #timer = 0;
  #text = "";

  override connectedCallback(): void {
    super.connectedCallback();
    this.store.on("moved", () => {
      clearTimeout(this.#timer);
      const { moved } = this.store;
      // The tour reports it in its own words.
      this.#text = moved > 0 && !this.store.tour ? t`Loop closed: the map moved by up to ${fixed(moved, moved < 0.95 ? 2 : 1)} m` : "";
      this.#timer = window.setTimeout(() => {
        this.#text = "";
        this.requestUpdate();
      }, SHOWN_MILLIS);
    });
  }

  override render(): TemplateResult {
    return html`<span role="status">${this.#text ? html`<div data-testid="moved">${this.#text}</div>` : ""}</span>`;
  }
}

customElements.define("slam-moved", SlamMoved);
