// Asks which topics of a ROS recording to use, if it has several lidars or odometries.

import { css, nothing, type TemplateResult } from "lit";
import type { OfferedTopic } from "../protocol/module.js";
import { html } from "../words.js";
import { dialog, SlamDialog } from "./dialog.js";
import { icons } from "./icons.js";

/** The module's name for "no odometry". */
const NONE = "none";

export class SlamTopics extends SlamDialog {
  static override styles = [dialog, css`
    fieldset { display: grid; gap: 8px; margin: 0 0 16px; padding: 0; border: 0; }
    legend { margin-bottom: 6px; padding: 0; font-weight: 620; }
    label { display: grid; grid-template-columns: auto minmax(0, 1fr); gap: 2px 10px; align-items: baseline; cursor: pointer; }
    code { font: 500 14px/1.3 var(--mono); overflow-wrap: anywhere; }
    small { grid-column: 2; font-size: 13px; color: var(--muted); overflow-wrap: anywhere; }
    form > button { justify-self: start; }
  `];

  protected override readonly topics = ["run"] as const;

  override updated(): void {
    if (this.store.asked !== null && !this.shown) this.show();
    else if (this.store.asked === null && this.shown) this.close();
  }

  override render(): TemplateResult {
    const { asked } = this.store;
    return html`<dialog aria-labelledby="title" data-testid="topics" @close=${() => this.#leave()}>
      <header><h3 id="title">Which topics?</h3><button class="icon" aria-label="Close" @click=${() => this.close()}>${icons.close}</button></header>
      ${asked ? html`
        <p>${asked.name} holds several that can be meant. Choose the lidar to map with, and what tells the robot's motion.</p>
        <form @submit=${(event: SubmitEvent) => this.#choose(event)}>
          ${choice("scans", "Scans", asked.offered.scans)}
          ${choice("odometry", "Odometry", [...asked.offered.odometry, { name: NONE, words: "the lidar alone, as if it were carried by hand" }])}
          <button class="primary" data-testid="topics-open">Map it</button>
        </form>` : nothing}
    </dialog>`;
  }

  #leave(): void {
    if (this.store.asked !== null) this.store.set("run", { asked: null });
  }

  #choose(event: SubmitEvent): void {
    event.preventDefault();
    const form = new FormData(event.target as HTMLFormElement);
    const chosen = (name: string): string | null => form.get(name)?.toString() ?? null;
    this.client.files.openTopics({ scans: chosen("scans"), odometry: chosen("odometry") });
  }
}

function choice(name: string, title: string, offered: readonly OfferedTopic[]): TemplateResult {
  return html`<fieldset><legend>${title}</legend>${offered.map((each, index) => html`
    <label><input type="radio" name=${name} value=${each.name} ?checked=${index === 0}><code>${each.name}</code><small>${each.words}</small></label>`)}
  </fieldset>`;
}

customElements.define("slam-topics", SlamTopics);
