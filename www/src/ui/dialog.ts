// A window over the page: its style, and how it opens and closes.

import { css } from "lit";
import { SlamElement } from "./element.js";

export const dialog = css`
  dialog { width: min(680px, calc(100vw - 24px)); max-height: calc(100dvh - 40px); padding: 26px 30px 30px; color: var(--ink); background: var(--surface); border: 1px solid var(--line); border-radius: 20px; box-shadow: var(--shadow); }
  dialog::backdrop { background: #0a1216a8; }
  header { display: flex; justify-content: space-between; align-items: start; gap: 12px; }
  h3 { margin: 0 0 8px; font: 620 24px/1.2 var(--sans); letter-spacing: -.02em; }
  p { margin: 0 0 12px; max-width: 62ch; line-height: 1.55; }
  @media (max-width: 760px) { dialog { padding: 18px; } }
`;

/** A component that is a dialog. */
export abstract class SlamDialog extends SlamElement {
  show(): void {
    this.#dialog()?.showModal();
  }

  close(): void {
    this.#dialog()?.close();
  }

  get shown(): boolean {
    return this.#dialog()?.open ?? false;
  }

  #dialog(): HTMLDialogElement | null {
    return this.renderRoot.querySelector("dialog");
  }
}
