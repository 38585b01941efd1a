// Saved, loaded and prior maps stand one step away: folded, until one of them is in use or somebody
// asks for them.

import type { TemplateResult } from "lit";
import { needsPriorMap } from "../protocol/methods.js";
import { html } from "../words.js";
import { mapsAreOpen, noteMapsOpen } from "../visit.js";
import { SlamElement } from "./element.js";
import { tool } from "./style.js";

export class SlamMaps extends SlamElement {
  static override styles = tool;

  protected override readonly topics = ["run", "submaps", "graph"] as const;
  #isOpen = mapsAreOpen();
  #isUsed = false;

  override render(): TemplateResult {
    const { savedMap, loadedMaps, solvedGraph, method } = this.store;
    const isUsed = savedMap !== null || loadedMaps.length > 0 || solvedGraph !== null || needsPriorMap(method);
    if (isUsed && !this.#isUsed) this.#isOpen = true;
    this.#isUsed = isUsed;
    document.querySelector("#map-tools")?.toggleAttribute("hidden", !this.#isOpen);
    return html`<details ?open=${this.#isOpen} @toggle=${(e: Event) => this.#toggle((e.target as HTMLDetailsElement).open)}><summary data-testid="maps">Submaps and other maps</summary></details>`;
  }

  #toggle(isOpen: boolean): void {
    if (isOpen === this.#isOpen) return;
    this.#isOpen = isOpen;
    noteMapsOpen(isOpen);
    this.requestUpdate();
  }
}

customElements.define("slam-maps", SlamMaps);
