// A hint for the first visit, dismissed for good by the first action, or when it has been read.

import { css, nothing, type TemplateResult } from "lit";
import { current as currentLesson } from "../lessons.js";
import { isTouched } from "../screen.js";
import { ifAllowed } from "../storage.js";
import { html } from "../words.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";

const KEY = "slamlab-tip-seen";
/** How long it stays, wall milliseconds. */
const READ_MILLIS = 10_000;

export class SlamTip extends SlamElement {
  static override styles = css`
    div { display: flex; align-items: center; gap: 8px; padding: 4px 4px 4px 14px; border-radius: 22px; max-width: calc(100vw - 24px); line-height: 1.3; background: var(--ink); color: var(--surface); font-size: 13.5px; box-shadow: var(--shadow); animation: in .4s ease-out; }
    button { border: 0; background: transparent; border-radius: 50%; min-height: 32px; width: 32px; }
    button:hover { background: #8883; }
    @keyframes in { from { opacity: 0; transform: translateY(6px); } }
  `;

  protected override readonly topics = ["run", "frame", "tab", "view", "tour", "exhibit", "lesson"] as const;
  #seen = ifAllowed(() => localStorage.getItem(KEY)) !== null;

  #timer = 0;

  override connectedCallback(): void {
    super.connectedCallback();
    // After a click on the map, the hint that it can be clicked is superfluous.
    addEventListener("click", (event) => {
      if (this.#timer !== 0 && event.composedPath().some((at) => at instanceof HTMLElement && at.localName === "slam-map")) this.dismiss();
    });
  }

  override render(): TemplateResult | typeof nothing {
    const { status, source, comparesPaths, layers, editing, inspecting, tour, exhibit } = this.store;
    // The tour gives the hint at its end, and an experiment has a story of its own. While rooms, or
    // start and goal, can be chosen, a click chooses those.
    if (this.#seen || tour || exhibit || currentLesson(this.store) || editing || inspecting || layers.rooms || comparesPaths || source !== "sim" || !status || status.time < 8 || status.finished) return nothing;
    if (status.mode !== "explore") {
      this.dismiss();
      return nothing;
    }
    this.#timer ||= window.setTimeout(() => this.dismiss(), READ_MILLIS);
    return html`<div data-testid="tip"><span>${isTouched() ? "Tap the map to send the robot there: you are asked first" : "Click the map to send the robot there: you are asked first"}</span><button class="icon" aria-label="Close the hint" @click=${() => this.dismiss()}>${icons.close}</button></div>`;
  }

  dismiss(): void {
    this.#seen = true;
    // Without storage the hint appears again on the next visit.
    ifAllowed(() => localStorage.setItem(KEY, "1"));
    this.requestUpdate();
  }
}

customElements.define("slam-tip", SlamTip);
