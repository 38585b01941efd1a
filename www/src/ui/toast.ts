// A sentence to be read now: what failed, and why.

import { css, nothing, type TemplateResult } from "lit";
import type { Toast } from "../store.js";
import { html, t } from "../words.js";
import { withCode } from "./code.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";

/** A longer text may have to be scrolled, by keyboard too. */
const LONG = 600;
/** How long good news stays, wall milliseconds. */
const GOOD_MILLIS = 8000;

export class SlamToast extends SlamElement {
  static override styles = css`
    :host { position: fixed; left: 50%; top: 72px; transform: translateX(-50%); z-index: 40; width: min(620px, calc(100vw - 24px)); pointer-events: none; }
    div { pointer-events: auto; display: flex; align-items: start; gap: 12px; padding: 12px 12px 12px 16px; border-radius: 14px; background: var(--raised); border: 1px solid var(--warn); border-left-width: 6px; box-shadow: var(--shadow); animation: in .18s ease-out; }
    @keyframes in { from { opacity: 0; transform: translateY(-8px); } }
    .good, .info { border-color: var(--good); }
    /* The name of a file may be as long as somebody likes; the button stays in sight. */
    p { margin: 6px 0; flex: 1; overflow-wrap: anywhere; max-height: 40vh; overflow-y: auto; }
    button { border-color: transparent; background: transparent; }
    @media (max-width: 760px) {
      div { flex-wrap: wrap; justify-content: end; gap: 4px 8px; }
      p { flex: 1 0 calc(100% - 60px); }
      .icon { order: 1; }
      .way { order: 2; }
    }
    .way { border-color: var(--line); white-space: nowrap; }
  `;

  protected override readonly topics = ["toast"] as const;
  #timer = 0;

  override connectedCallback(): void {
    super.connectedCallback();
    this.store.on("toast", () => {
      clearTimeout(this.#timer);
      // Good news disappears by itself; the log keeps it.
      const { toast } = this.store;
      const stands = toast?.stands ?? (toast?.level === "good" ? GOOD_MILLIS : null);
      if (stands !== null) this.#timer = window.setTimeout(() => this.store.set("toast", { toast: null }), stands);
    });
  }

  override render(): TemplateResult | typeof nothing {
    const { toast } = this.store;
    return html`<span role="alert">${toast
      ? html`<div class=${toast.level} data-testid="toast"><p tabindex=${toast.text.length > LONG ? 0 : nothing}>${withCode(t(toast.text))}</p>
          ${toast.way ? html`<button class="way" data-testid="toast-way" @click=${() => this.#take(toast.way)}>${toast.way.label}</button>` : nothing}
          <button class="icon" data-testid="toast-close" aria-label="Close the message" @click=${() => this.store.set("toast", { toast: null })}>${icons.close}</button></div>`
      : nothing}</span>`;
  }

  /** In the editor it lies below the tools, however many lines they take. */
  override updated(): void {
    const tools = this.store.toast && document.querySelector("slam-editor")?.shadowRoot?.querySelector(".head");
    this.style.top = tools ? `${tools.getBoundingClientRect().bottom + 8}px` : "";
  }

  #take(way: Toast["way"]): void {
    this.store.set("toast", { toast: null });
    way?.go();
  }
}

customElements.define("slam-toast", SlamToast);
