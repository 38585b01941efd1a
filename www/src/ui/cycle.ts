// The cycle as a strip: the present stage, the results of each and the reasons, and a button for
// the next one.

import { css, nothing, type TemplateResult } from "lit";
import type { Stage } from "../protocol/module.js";
import { html } from "../words.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";

interface Words {
  label: string;
  meaning: string;
}

/** The purpose of each stage (TDK 2016 §6.3). */
const STAGES: Readonly<Record<Stage, Words>> = {
  init: { label: "Init", meaning: "The first pose is known by definition: (0, 0, 0) is where the robot stands." },
  scan: { label: "Scan", meaning: "The robot stands while the sensor scans, so that no motion bends the picture." },
  lines: { label: "Lines", meaning: "Neighbouring readings on one straight piece become a line with its uncertainty." },
  localise: { label: "Localise", meaning: "Lines that are known walls correct the pose; the others are new walls, or left out." },
  map: { label: "Map", meaning: "Walls grow by what was seen of them, and the grid is drawn from the corrected pose." },
  plan: { label: "Plan", meaning: "A path to the goal is searched for in the map, again after each scan." },
  truncate: { label: "Truncate", meaning: "Only the first turn and leg are kept, no farther than was seen and odometry can be trusted." },
  turn: { label: "Turn", meaning: "On the spot, towards the first leg." },
  go: { label: "Go", meaning: "Straight on along the leg. Then it stands and scans again." },
};

export class SlamCycle extends SlamElement {
  static override styles = css`
    :host { width: 100%; max-width: 640px; padding: 8px 10px; border: 1px solid var(--line); border-radius: 14px; background: var(--glass); box-shadow: var(--shadow); }
    ol { display: grid; grid-template-columns: repeat(9, 1fr); gap: 3px; margin: 0; padding: 0; list-style: none; }
    li button { transition: none; width: 100%; min-height: 32px; padding: 0 2px; border: 0; border-radius: 8px; background: var(--sunk); font-size: 12px; color: var(--muted); box-shadow: inset 0 -3px 0 var(--line); }
    li button:hover { background: var(--hover); }
    li.done button { color: var(--ink); box-shadow: inset 0 -3px 0 var(--good); }
    li.now button { background: var(--accent); color: var(--on-accent); box-shadow: none; }
    li.chosen button { outline: 2px solid var(--focus); outline-offset: -2px; }
    .foot { display: flex; gap: 12px; align-items: center; margin-top: 8px; }
    p { flex: 1; min-width: 0; margin: 0; min-height: 38px; font-size: 12.5px; line-height: 1.5; }
    p b { font-weight: 600; }
    p small { display: block; font-size: 12px; color: var(--muted); }
    .next { flex: none; }
    @media (max-width: 760px) {
      :host { border-radius: 0; border-width: 1px 0 0; box-shadow: none; max-width: none; padding: 8px; }
      li button { min-height: 40px; font-size: 10px; letter-spacing: -.02em; overflow: hidden; }
      p small { display: none; }
      p { min-height: 36px; max-height: 36px; overflow: hidden; font-size: 12px; }
      .next { padding: 0 10px; }
    }
  `;

  protected override readonly topics = ["cycle", "run"] as const;
  /** The stage that is shown; null for the newest. */
  #chosen: Stage | null = null;

  override render(): TemplateResult | typeof nothing {
    const { store } = this;
    const shows = store.inCycle;
    this.toggleAttribute("hidden", !shows);
    document.body.toggleAttribute("data-cycle", shows);
    if (!shows) return nothing;
    const { cycle } = store;
    const stages = cycle?.stages ?? (Object.keys(STAGES) as Stage[]).map((stage) => ({ stage, text: "" }));
    const now = cycle?.now ?? null;
    const name = this.#chosen ?? now ?? "init";
    const shown = stages.find(({ stage }) => stage === name);
    const words = STAGES[name];
    return html`<section aria-label="The cycle" data-testid="cycle" data-now=${now ?? ""}>
      <ol>${stages.map(({ stage, text }) => html`<li class="${text ? "done" : ""} ${stage === now ? "now" : ""} ${stage === this.#chosen ? "chosen" : ""}">
        <button data-testid="stage-${stage}" aria-current=${stage === now ? "step" : nothing} aria-pressed=${stage === this.#chosen}
          title=${text || STAGES[stage].meaning} @click=${() => this.#choose(stage)}>${STAGES[stage].label}</button></li>`)}</ol>
      <div class="foot">
        <p aria-live="polite" data-testid="stage-words"><b>${words.label}</b>${cycle && cycle.round > 0 ? html` <span class="muted">round ${cycle.round}</span>` : ""} · ${shown?.text || "not yet"}<small>${words.meaning}</small></p>
        ${store.source !== "sim" ? nothing : html`<button class="next" data-testid="next-stage" title="Go on to the end of the next stage, then pause (.)" ?disabled=${store.status?.finished ?? false}
          @click=${this.press(() => this.next())}>${icons.step} Next stage</button>`}
      </div>
    </section>`;
  }

  /** Goes one stage on, and shows the newest stage again. */
  next(): void {
    if (!this.store.inCycle || this.store.source !== "sim") return;
    this.#chosen = null;
    this.client.send({ kind: "stage" });
  }

  #choose(stage: Stage): void {
    this.#chosen = this.#chosen === stage ? null : stage;
    this.requestUpdate();
  }
}

customElements.define("slam-cycle", SlamCycle);
