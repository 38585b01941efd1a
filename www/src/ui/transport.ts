// Time and purpose: play, step, speed, what the robot should do, and Stop.

import { css, type TemplateResult } from "lit";
import type { Mode } from "../protocol/module.js";
import { anySeed } from "../seed.js";
import { noteChoice } from "../visit.js";
import { html, t } from "../words.js";
import { SlamElement } from "./element.js";
import { clock, percent } from "./format.js";
import { icons } from "./icons.js";
import { valueOf } from "./input.js";

const SPEEDS = [0.25, 0.5, 1, 2, 4, 10, 20, 50, Infinity];

export class SlamTransport extends SlamElement {
  static override styles = css`
    :host { display: flex; align-items: center; gap: 10px; padding: 8px; border: 1px solid var(--line); border-radius: 16px; background: var(--glass); box-shadow: var(--shadow); }
    .time { display: flex; gap: 6px; align-items: center; }
    .play { width: 44px; height: 44px; border-radius: 12px; background: var(--ink); color: var(--surface); border-color: transparent; }
    .play:hover { background: var(--ink); opacity: .88; }
    .lease { min-height: 44px; border-radius: 12px; }
    .lease[aria-pressed="true"] { background: var(--ink); color: var(--surface); border-color: transparent; }
    select { width: auto; min-width: 78px; min-height: 44px; }
    .time .icon { height: 44px; width: 40px; }
    .modes { display: flex; padding: 3px; gap: 2px; border-radius: 12px; background: var(--sunk); border: 1px solid var(--line); }
    .modes button { border: 0; background: transparent; min-height: 36px; border-radius: 9px; }
    .modes button:hover { background: var(--hover); }
    .modes button[aria-pressed="true"] { background: var(--accent); color: var(--on-accent); }
    .modes .cycle { border-left: 1px solid var(--line); border-radius: 0 9px 9px 0; }
    .modes .cycle[aria-pressed="true"] { background: var(--ink); color: var(--surface); border-radius: 9px; opacity: 1; }
    .stop { min-height: 44px; padding: 0 18px; border-radius: 12px; border-color: transparent; background: var(--danger); color: #fff; font-weight: 700; letter-spacing: .04em; }
    .stop:hover { background: var(--danger-hover); border-color: transparent; }
    .progress { display: flex; flex-direction: column; gap: 5px; flex: 1 1 190px; min-width: 70px; font-size: 12.5px; }
    .progress div { display: flex; justify-content: space-between; gap: 12px; white-space: nowrap; }
    .progress .muted { overflow: hidden; text-overflow: ellipsis; }
    progress { appearance: none; width: 100%; height: 6px; border: 0; border-radius: 3px; overflow: hidden; background: var(--sunk); }
    progress::-webkit-progress-bar { background: var(--sunk); }
    progress::-webkit-progress-value { background: var(--accent); }
    progress::-moz-progress-bar { background: var(--accent); }
    @container stage (max-width: 710px) {
      .modes svg, .stop svg { display: none; }
      select { min-width: 58px; padding: 0 2px; }
      :host { gap: 5px; padding: 6px; }
      .time { gap: 4px; }
      .time .icon { width: 34px; }
      .time .play { width: 40px; }
      .modes { padding: 2px; gap: 0; }
      .modes button { padding: 0 7px; font-size: 13px; }
      .stop { padding: 0 9px; font-size: 13px; }
      .progress { flex: 1 1 60px; min-width: 0; }
      .progress .muted { display: none; }
      .word { display: none; }
    }
    /* A tablet held upright, with the panels beside the map. */
    @container stage (max-width: 470px) {
      :host { gap: 4px; padding: 5px; }
      .time { gap: 3px; }
      select { min-width: 50px; }
      .modes button { padding: 0 5px; }
      .stop { padding: 0 7px; }
    }
    @media (max-width: 760px) {
      .modes svg, .stop svg { display: block; }
      .word { display: inline; }
      :host { flex-wrap: wrap; gap: 8px; border-radius: 0; border-width: 1px 0 0; box-shadow: none; padding: 8px 10px; }
      .modes, .progress { order: -1; flex: 1 0 100%; }
      .modes button { flex: 1; padding: 0 4px; min-height: 40px; gap: 5px; font-size: 13px; }
      .time { flex: 1; }
      select { flex: 1; }
      .stop { flex: 1; }
    }
  `;

  protected override readonly topics = ["frame", "run", "bridge"] as const;

  override render(): TemplateResult {
    const { store, client } = this;
    const finished = store.status?.finished ?? false;
    return html`
      ${store.source === "bridge" ? this.#lease() : html`<div class="time" role="group" aria-label="Time">
        ${finished && !store.reading
          ? html`<button class="play" data-testid="play-again" aria-label="Once more" title=${store.source === "sim" ? "Once more, with another seed: the same building, other errors" : "Once more, from its beginning (R)"}
              @click=${this.press(() => this.#again())}>${icons.again}</button>`
          : html`<button class="play" data-testid="play" aria-label=${store.playing ? "Pause" : "Play"} title="${store.playing ? "Pause" : "Play"} (P)"
              @click=${this.press(() => client.send({ kind: store.playing ? "pause" : "play" }))}>${store.playing ? icons.pause : icons.play}</button>`}
        <button class="icon" data-testid="step" aria-label="Step one scan" title="Step one scan (N)" ?disabled=${finished}
          @click=${this.press(() => client.send({ kind: "step" }))}>${icons.step}</button>
        <select data-testid="speed" aria-label="Speed" title="Speed ([ and ])"
          @change=${(e: Event) => { this.#setSpeed(Number(valueOf(e))); (e.target as HTMLSelectElement).blur(); }}>
          ${SPEEDS.map((s) => html`<option value=${String(s)} .selected=${s === store.speed}>${s === Infinity ? "max" : `${s} ×`}</option>`)}
        </select>
      </div>`}
      ${store.source !== "replay" && !store.reading ? this.#modes() : this.#progress()}
      <button class="stop" data-testid="stop" title="Stop the robot (Esc or space)" @click=${this.press(() => client.stop())}>${icons.stop} STOP</button>
    `;
  }

  /** Starts a finished run again, with another seed: the same one would give the same run. */
  #again(): void {
    if (this.store.source === "sim") this.client.start({ mode: "explore", seed: anySeed() });
    else this.client.again();
  }

  /** Changes the speed by one step. */
  shift(by: 1 | -1): void {
    const at = SPEEDS.indexOf(this.store.speed);
    const next = SPEEDS[Math.min(Math.max(at + by, 0), SPEEDS.length - 1)];
    if (next !== undefined) this.#setSpeed(next);
  }

  #setSpeed(speed: number): void {
    // A recording has a speed of its own.
    if (this.store.source === "sim") noteChoice(this.store, { speed });
    this.client.setSpeed(speed);
  }

  /** Who drives a real robot, in place of the time controls, which it cannot have. */
  #lease(): TemplateResult {
    const { bridge } = this.store;
    const drives = bridge?.armed ?? false;
    const others = !drives && !bridge?.hasLease && (bridge?.driver ?? "") !== "";
    const words = drives ? "Let go" : others ? "Take over" : "Drive";
    // Undoing an emergency stop needs the right to drive first.
    const may = bridge?.connection === "open" && bridge.mayDrive && !(bridge.emergency && bridge.hasLease);
    const why = bridge?.mayDrive === false ? "Only with the token of a driver or an owner: open the address that holds it"
      : drives ? "Give back the right to drive; the robot stops" : others ? t`${bridge?.driver} drives; taking over stops the robot first` : "Take the right to drive, and arm the robot";
    return html`<button class="lease" data-testid="lease" aria-pressed=${drives} ?disabled=${!may} title=${why}
      @click=${this.press(() => this.client.robot.lease(!drives))}>${icons.hand} ${words}</button>`;
  }

  #modes(): TemplateResult {
    const { store, client } = this;
    const idle = store.source === "bridge" && !store.bridge?.armed;
    const now: Mode = store.aiming ? "goto" : (store.status?.mode ?? store.setup.mode);
    const mode = (name: Mode, label: string, key: string, icon: TemplateResult, act: () => void): TemplateResult => html`
      <button data-testid="mode-${name}" aria-pressed=${now === name} ?disabled=${idle} title="${label} (${key})"
        @click=${this.press(() => act())}>${icon}${label}</button>`;
    return html`<div class="modes" role="group" aria-label="Mode">
      ${mode("manual", "Manual", "1", icons.hand, () => client.manual())}
      ${mode("goto", "Go to", "2", icons.pin, () => client.aim())}
      ${mode("explore", "Explore", "3", icons.compass, () => client.explore())}
      <button class="cycle" data-testid="mode-cycle" aria-pressed=${store.inCycle || store.setup.cycle} ?disabled=${idle || (store.inCycle && !store.setup.cycle)}
        title=${store.inCycle && !store.setup.cycle ? "This sensor scans only while the robot stands: the robot always drives by the cycle" : "The cycle (4): scan standing, plan, one turn, one leg, again"}
        @click=${this.press(() => client.setCycle(!store.setup.cycle))}>${icons.cycle}Cycle</button>
    </div>`;
  }

  #progress(): TemplateResult {
    const { store, client } = this;
    const { reading, status } = store;
    const done = reading?.done ?? (Number.isFinite(status?.progress) ? (status?.progress ?? 0) : 0);
    const left = reading ? "reading" : status?.finished ? status.reason : Number.isFinite(status?.remaining) ? t`${clock(status?.remaining ?? NaN)} left` : "";
    return html`<div class="progress" data-testid="progress">
        <div class="num"><span>${percent(done)}</span><span class="muted">${left}</span></div>
        <progress max="1" .value=${done} aria-label="Part of the recording that is done"></progress>
      </div>
      ${status?.finished && !reading
        ? html`<button data-testid="to-simulation" title="Back to the simulation" aria-label="Back to the simulation" @click=${() => client.start({ mode: "explore" })}>${icons.compass} <span class="word">Simulation</span></button>`
        : html`<button data-testid="cancel" aria-label="Cancel" @click=${() => client.send({ kind: "cancel" })}>${icons.close} <span class="word">Cancel</span></button>`}`;
  }
}

customElements.define("slam-transport", SlamTransport);
