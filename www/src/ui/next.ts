// Suggestions at the end of a run, until something is done or they are closed.

import { css, nothing, type TemplateResult } from "lit";
import { current as currentLesson } from "../lessons.js";
import { isNarrow } from "../screen.js";
import { html } from "../words.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";

export class SlamNext extends SlamElement {
  static override styles = css`
    div { display: flex; flex-wrap: wrap; align-items: center; justify-content: center; gap: 6px; padding: 4px 4px 4px 16px; border-radius: 22px; max-width: calc(100vw - 24px); background: var(--ink); color: var(--surface); font-size: 13.5px; box-shadow: var(--shadow); animation: in .4s ease-out; }
    button { border: 0; border-radius: 18px; min-height: 32px; padding: 0 12px; color: inherit; background: color-mix(in srgb, var(--surface) 16%, transparent); white-space: nowrap; }
    button:hover { background: color-mix(in srgb, var(--surface) 30%, transparent); }
    button.icon { width: 32px; padding: 0; background: transparent; }
    @media (max-width: 760px) {
      div { gap: 4px; padding: 0 6px 6px; max-width: 356px; justify-content: start; }
      span { flex: 1 0 calc(100% - 60px); order: -2; padding-left: 8px; white-space: nowrap; }
      button { flex: 1 0 auto; min-height: 40px; padding: 0 4px; font-size: 13px; }
      button.icon { flex: none; width: 40px; order: -1; }
    }
    @keyframes in { from { opacity: 0; transform: translateY(6px); } }
  `;

  protected override readonly topics = ["run", "frame", "tab", "view", "tour", "exhibit", "lesson"] as const;
  #closed = false;
  /** The run is over. Stopping a robot that has finished changes nothing: the run stays over. */
  #isOver = false;

  override render(): TemplateResult | typeof nothing {
    const { status, source, tab, comparesPaths, layers, editing, inspecting, isStopped, tour, exhibit, offer: { worlds }, setup } = this.store;
    this.#isOver = status !== null && (status.finished || (this.#isOver && isStopped));
    if (!this.#isOver) this.#closed = false;
    // Tour, experiment and lesson have next steps of their own, runs side by side are already
    // compared, and a robot behind a bridge is up to its driver. On a phone an open sheet covers
    // the map.
    if (!this.#isOver || this.#closed || source === "bridge" || tour || exhibit || currentLesson(this.store) || editing || inspecting || document.body.dataset["race"] !== undefined) return nothing;
    if (layers.rooms || comparesPaths || (tab !== "" && isNarrow())) return nothing;
    const world = worlds[(worlds.indexOf(setup.world) + 1) % worlds.length];
    return html`<div data-testid="next" role="group" aria-label="What next?"><span>What next?</span>
      ${source === "sim" && world !== undefined ? html`<button data-testid="next-world" title="The robot maps a building that it has never seen" @click=${this.#do(() => this.client.start({ world, worldJson: null, mode: "explore" }))}>Another building</button>` : nothing}
      <button data-testid="next-compare" title="Other methods or settings on the same run, side by side (C)" @click=${this.#do(() => dispatchEvent(new Event("show-race")))}>Compare methods</button>
      ${source === "sim" ? html`<button data-testid="next-gallery" title="Experiments: runs in which one thing is seen (G)" @click=${this.#do(() => dispatchEvent(new Event("show-gallery")))}>Experiments</button>`
        : html`<button data-testid="next-save" title="The map and all else that can be kept (Y)" @click=${this.#do(() => dispatchEvent(new Event("show-saving")))}>Save…</button>`}
      <button class="icon" aria-label="Close the offer" @click=${this.#do(() => undefined)}>${icons.close}</button>
    </div>`;
  }

  #do(act: () => void): (event: Event) => void {
    return this.press(() => {
      this.#closed = true;
      this.requestUpdate();
      act();
    });
  }
}

customElements.define("slam-next", SlamNext);
