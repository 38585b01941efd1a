// Asks what the poses of another file are to a recording, once, when they are opened.

import { css, nothing, type TemplateResult } from "lit";
import type { PosesAs } from "../protocol/module.js";
import { html } from "../words.js";
import { dialog, SlamDialog } from "./dialog.js";
import { icons } from "./icons.js";

type Answer = PosesAs | "path";

const ANSWERS: Readonly<Record<Answer, { title: string; about: string }>> = {
  odometry: { title: "Odometry", about: "How the robot moved by its wheels or its inertial sensors: the recording is mapped with it, in place of its own." },
  truth: { title: "Truth", about: "Where the robot really was: errors are drawn against it, aligned so that both ways come closest, as evo does." },
  path: { title: "A path to look at", about: "Drawn beside the way of the run, and nothing else." },
};

export class SlamPoses extends SlamDialog {
  static override styles = [dialog, css`
    div { display: grid; gap: 10px; }
    div button { display: grid; gap: 2px; height: auto; padding: 12px 14px; justify-items: start; text-align: start; white-space: normal; }
    small { font-size: 13px; font-weight: 400; line-height: 1.4; color: var(--muted); }
  `];

  protected override readonly topics = ["run"] as const;

  override updated(): void {
    if (this.store.posesAsked !== null && !this.shown) this.show();
    else if (this.store.posesAsked === null && this.shown) this.close();
  }

  override render(): TemplateResult {
    const { posesAsked: asked, title } = this.store;
    return html`<dialog aria-labelledby="title" data-testid="poses" @close=${() => this.#leave()}>
      <header><h3 id="title">What are these poses?</h3><button class="icon" aria-label="Close" @click=${() => this.close()}>${icons.close}</button></header>
      ${asked ? html`
        <p>${asked.poses.name} tells where a robot was, on the clock of ${asked.log?.name ?? title}.</p>
        <div>${(["odometry", "truth"] as const).map((each) => this.#answer(each))}${asked.log ? nothing : this.#answer("path")}</div>` : nothing}
    </dialog>`;
  }

  #answer(answer: Answer): TemplateResult {
    const { title, about } = ANSWERS[answer];
    return html`<button data-testid="poses-${answer}" @click=${() => this.client.files.posesAre(answer)}><b>${title}</b><small>${about}</small></button>`;
  }

  #leave(): void {
    if (this.store.posesAsked !== null) this.store.set("run", { posesAsked: null });
  }
}

customElements.define("slam-poses", SlamPoses);
