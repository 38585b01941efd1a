// Saved, loaded and prior maps: folded until one of them is in use or somebody opens the fold. Only
// then is their code loaded.

import { css, nothing, type TemplateResult } from "lit";
import { bundle } from "../bundle.js";
import { needsPriorMap } from "../protocol/methods.js";
import { html } from "../words.js";
import { mapsAreOpen, noteMapsOpen } from "../visit.js";
import { SlamElement } from "./element.js";
import { tool } from "./style.js";

const TOOLS = ["slam-saved-map", "slam-submaps", "slam-pose-graph", "slam-prior-map"];

export class SlamMaps extends SlamElement {
  static override styles = [tool, css`
    details[open] { padding-bottom: 18px; }
  `];

  protected override readonly topics = ["run", "submaps", "graph"] as const;
  #isOpen = mapsAreOpen();
  #isUsed = false;
  /** Created when they are first shown. */
  #tools: HTMLElement[] | null = null;

  override render(): TemplateResult {
    const { savedMap, loadedMaps, solvedGraph, method } = this.store;
    const isUsed = savedMap !== null || loadedMaps.length > 0 || solvedGraph !== null || needsPriorMap(method);
    if (isUsed && !this.#isUsed) this.#isOpen = true;
    this.#isUsed = isUsed;
    return html`<details ?open=${this.#isOpen} @toggle=${(e: Event) => this.#toggle((e.target as HTMLDetailsElement).open)}>
      <summary data-testid="maps">Submaps and other maps</summary>${this.#tools ?? nothing}</details>`;
  }

  override updated(): void {
    if (!this.#isOpen || this.#tools) return;
    const { store, scene, client } = this;
    this.#tools = TOOLS.map((tag) => Object.assign(document.createElement(tag), { store, scene, client }));
    this.requestUpdate();
    void bundle(store, "panels.js", "This panel").then((part) => {
      if (part) return;
      // Opening it again tries again.
      [this.#tools, this.#isOpen] = [null, false];
      this.requestUpdate();
    });
  }

  #toggle(isOpen: boolean): void {
    if (isOpen === this.#isOpen) return;
    this.#isOpen = isOpen;
    noteMapsOpen(isOpen);
    this.requestUpdate();
  }
}

customElements.define("slam-maps", SlamMaps);
