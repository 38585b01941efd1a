// Reports that a gamepad is connected, what its stick does and its present state; and its removal.

import { css, nothing, type TemplateResult } from "lit";
import type { GamepadState } from "../gamepad.js";
import { html, t } from "../words.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";

/** Largest offset of the dot from the centre of the ring, of 24. */
const REACH = 7;

export class SlamGamepad extends SlamElement {
  static override styles = css`
    div { display: flex; align-items: center; gap: 9px; padding: 5px 14px 5px 11px; border-radius: 18px; max-width: 100%; background: var(--glass); border: 1px solid var(--line); box-shadow: var(--shadow); font-size: 12.5px; line-height: 1.3; }
    svg { width: 22px; height: 22px; flex: none; }
    .ring { fill: none; stroke: var(--line-strong); stroke-width: 1.5; }
    .dot { fill: var(--accent); }
    .stops .ring { stroke: var(--danger); stroke-width: 3; }
    b { font-weight: 600; }
    span { min-width: 0; }
  `;

  protected override readonly topics = ["gamepad", "run", "bridge"] as const;
  #before: GamepadState | null = null;

  override render(): TemplateResult {
    const { gamepad } = this.store;
    // A status: read aloud when a gamepad is connected, changes its function, or is removed.
    return html`<div role="status" data-testid="gamepad" ?hidden=${!gamepad} class=${gamepad?.stops ? "stops" : ""}>${gamepad
      ? html`${icons.gamepad}
        <svg viewBox="0 0 24 24" aria-hidden="true" data-testid="gamepad-stick"><circle class="ring" cx="12" cy="12" r="10.5"/><circle class="dot" r="3.6" cx=${12 - REACH * gamepad.turn} cy=${12 - REACH * gamepad.forward}/></svg>
        <span><b>${gamepad.name}</b> ${this.#use()}</span>`
      : nothing}</div>`;
  }

  override updated(): void {
    const { gamepad } = this.store;
    const before = this.#before;
    this.#before = gamepad;
    if (before && !gamepad) this.store.set("toast", { toast: { level: "info", text: t`${before.name} is gone: it drives no longer. Keys and the stick on the map do.` } });
  }

  /** What moving its stick does at present. */
  #use(): string {
    const { source, bridge } = this.store;
    if (source === "replay") return "has nothing to drive in a recording";
    if (source === "bridge" && bridge?.armed !== true) return "drives once this page may drive the robot";
    return "left stick drives, B or right trigger stops";
  }
}

customElements.define("slam-gamepad", SlamGamepad);
