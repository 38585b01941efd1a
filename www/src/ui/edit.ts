// Edits the map by hand: chooses what a drag on it does.

import { css, nothing, type TemplateResult } from "lit";
import { EDIT_STRIDE, type EditName } from "../protocol/module.js";
import { html } from "../words.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";

const WORDS: Readonly<Record<EditName, { label: string; hint: string }>> = {
  erase: { label: "Erase", hint: "Drag a box: what is in it is unknown again, until it is seen anew." },
  wall: { label: "Wall", hint: "Drag a line: a wall stands there, whatever the sensor says." },
  glass: { label: "Glass", hint: "Drag a line: glass stands there, which beams go through." },
};

export class SlamEdit extends SlamElement {
  static override styles = css`
    section { display: grid; gap: 8px; width: min(440px, calc(100vw - 24px)); padding: 10px 12px; border: 1px solid var(--line); border-radius: 14px; background: var(--raised); box-shadow: var(--shadow); animation: in .18s ease-out; }
    @keyframes in { from { opacity: 0; transform: translateY(6px); } }
    .row { display: flex; gap: 8px; }
    .kinds { display: flex; flex: 1; padding: 3px; gap: 2px; border-radius: 12px; background: var(--sunk); border: 1px solid var(--line); }
    .kinds button { flex: 1; border: 0; background: transparent; min-height: 34px; border-radius: 9px; padding: 0 8px; }
    .kinds button:hover { background: var(--hover); }
    .kinds button[aria-pressed="true"] { background: var(--ink); color: var(--surface); }
    p { margin: 0; font-size: 13px; line-height: 1.4; color: var(--muted); }
    @media (pointer: coarse) { button, .kinds button { min-height: 44px; } }
    @media (max-width: 760px) { section { margin: 0 12px; } }
  `;

  protected override readonly topics = ["run", "frame"] as const;

  override render(): TemplateResult | typeof nothing {
    const { editing } = this.store;
    if (!editing) return nothing;
    return html`<section aria-label="Change the map" data-testid="edit">
      <div class="row">
        <div class="kinds" role="group" aria-label="What is drawn">
          ${Object.entries(WORDS).map(([kind, { label }]) => html`<button data-testid="edit-${kind}" aria-pressed=${kind === editing} @click=${() => this.store.set("run", { editing: kind as EditName })}>${label}</button>`)}
        </div>
        <button data-testid="edit-undo" title="Take the last change back" ?disabled=${this.scene.edits.length < EDIT_STRIDE} @click=${() => this.client.send({ kind: "undo-edit" })}>${icons.undo} Undo</button>
        <button data-testid="edit-done" @click=${() => this.store.set("run", { editing: null })}>Done</button>
      </div>
      <p aria-live="polite">${WORDS[editing].hint}</p>
    </section>`;
  }
}

customElements.define("slam-edit", SlamEdit);
