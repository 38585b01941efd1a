// Opens files dropped anywhere on the page.

import { css, nothing, type TemplateResult } from "lit";
import { opened } from "../chosen.js";
import { html } from "../words.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";

export class SlamDrop extends SlamElement {
  static override styles = css`
    div { position: fixed; inset: 12px; isolation: isolate; z-index: 50; display: grid; place-content: center; justify-items: center; gap: 14px; text-align: center; border: 3px dashed var(--accent); border-radius: 24px; background: color-mix(in srgb, var(--surface) 96%, transparent); padding: 24px; pointer-events: none; }
    span { max-width: 60ch; }
    svg { width: 56px; height: 56px; color: var(--accent-ink); }
    b { font-size: 22px; font-weight: 600; }
  `;

  #over = false;

  override connectedCallback(): void {
    super.connectedCallback();
    let depth = 0;
    const carriesFiles = (event: DragEvent): boolean => event.dataTransfer?.types.includes("Files") ?? false;
    addEventListener("dragenter", (event) => {
      if (!carriesFiles(event)) return;
      event.preventDefault();
      depth += 1;
      this.#show(true);
    });
    addEventListener("dragover", (event) => carriesFiles(event) && event.preventDefault());
    addEventListener("dragleave", () => {
      depth = Math.max(0, depth - 1);
      if (depth === 0) this.#show(false);
    });
    addEventListener("drop", (event) => {
      event.preventDefault();
      depth = 0;
      this.#show(false);
      void this.client.files.openAll([...(event.dataTransfer?.files ?? [])]);
    });
  }

  override render(): TemplateResult | typeof nothing {
    return this.#over ? html`<div>${icons.open}<b>Drop it here</b><span>${opened()}</span></div>` : nothing;
  }

  #show(over: boolean): void {
    if (over === this.#over) return;
    this.#over = over;
    this.requestUpdate();
  }
}

customElements.define("slam-drop", SlamDrop);
