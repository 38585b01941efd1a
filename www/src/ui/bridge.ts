// The robot behind a bridge: devices, link, battery, who drives, recording, emergency stop. Hidden
// if there is no bridge.

import { css, nothing, type TemplateResult } from "lit";
import { bundle } from "../bundle.js";
import type { BridgeState } from "../protocol/devices.js";
import type { DeviceStateName, DeviceStatus, RoleName } from "../protocol/module.js";
import { html, t } from "../words.js";
import { REASONS } from "./disarm_words.js";
import { SlamElement } from "./element.js";
import { figure, figures } from "./figures.js";
import { DASH, fixed } from "./format.js";
import { icons } from "./icons.js";

/** Each state has a word too: not everyone can tell colours apart. */
const STATES: Readonly<Record<DeviceStateName, { word: string; tone: string }>> = {
  waiting: { word: "waiting", tone: "warn" },
  connected: { word: "connected", tone: "" },
  measuring: { word: "measuring", tone: "" },
  sending: { word: "sending", tone: "good" },
  fault: { word: "fault", tone: "bad" },
};

/** What a role allows. */
const ROLES: Readonly<Record<RoleName, string>> = {
  watcher: "may look, and stop the robot",
  driver: "may drive",
  owner: "may drive, take the robot from anybody, and say where it may be",
};

export class SlamBridge extends SlamElement {
  static override styles = [
    figures,
    css`
      :host { padding-bottom: 16px; margin-bottom: 16px; border-bottom: 1px solid var(--line); }
      h2 { margin-bottom: 10px; }
      ul { list-style: none; margin: 0 0 10px; padding: 0; display: grid; gap: 8px; font-size: 13px; }
      li { display: grid; grid-template-columns: 10px 1fr auto; gap: 2px 8px; align-items: baseline; }
      i { width: 8px; height: 8px; border-radius: 50%; background: var(--muted); align-self: center; }
      i.good { background: var(--good-ink); }
      i.warn { box-sizing: border-box; background: none; border: 2px solid var(--warn-ink); }
      i.bad { background: var(--danger); }
      small { grid-column: 2 / -1; color: var(--muted); line-height: 1.4; overflow-wrap: anywhere; }
      dl { margin: 0 0 10px; }
      dt { white-space: nowrap; }
      p { margin: 0 0 10px; font-size: 13px; line-height: 1.45; }
      details { margin: 0 0 10px; }
      summary { min-height: 34px; font-size: 13px; cursor: pointer; align-content: center; }
      .row { display: flex; flex-wrap: wrap; gap: 6px 12px; align-items: center; }
      fieldset { margin: 0 0 10px; padding: 8px 10px 2px; border: 1px solid var(--line); border-radius: 12px; }
      legend { padding: 0 4px; font-size: 13px; font-weight: 600; }
      label { display: inline-flex; gap: 6px; align-items: center; min-height: 34px; font-size: 13px; }
      @media (pointer: coarse) { label, .row button { min-height: 44px; } }
      .emergency { width: 100%; min-height: 44px; border: 2px solid var(--danger); color: var(--danger); font-weight: 700; }
      .emergency[aria-pressed="true"] { background: var(--danger); color: #fff; }
    `,
  ];

  protected override readonly topics = ["bridge", "run"] as const;
  #canList = false;
  #ofMap: Promise<void> | null = null;
  #renderMap: typeof import("./bridge_map.js").render | null = null;

  override render(): TemplateResult | typeof nothing {
    const { bridge } = this.store;
    this.toggleAttribute("hidden", !bridge);
    if (!bridge) return nothing;
    return html`
      <h2>Robot</h2>
      <p role="status" data-testid="bridge-state">${sentence(bridge)}</p>
      ${bridge.connection === "open" ? state(bridge) : ""}
      ${this.#map(bridge)}
      ${bridge.recording && bridge.connection === "open" ? html`<details data-testid="recordings-of-bridge" @toggle=${this.#lists}><summary>Recordings</summary>${this.#canList ? html`<slam-recordings .store=${this.store} .client=${this.client}></slam-recordings>` : nothing}</details>` : nothing}
      <button class="emergency" data-testid="emergency" aria-pressed=${bridge.emergency} ?disabled=${(bridge.connection !== "open" && this.client.robot.plugged.length === 0) || (bridge.emergency && !bridge.hasLease)}
        title=${bridge.emergency ? "Take the right to drive, then undo the emergency stop; nothing moves by that" : "Cuts the motors off; they stay off until this is undone"}
        @click=${() => this.client.robot.emergency(!bridge.emergency)}>${icons.stop} ${bridge.emergency ? "Undo the emergency stop" : "Emergency stop"}</button>
    `;
  }

  /** The lists ask the bridge only when they are opened. */
  readonly #lists = async (event: Event): Promise<void> => {
    const isOpen = (event.currentTarget as HTMLDetailsElement).open;
    this.#canList = isOpen && (await bundle(this.store, "recordings.js", "The list of recordings")) !== null;
    this.requestUpdate();
  };

  /** The panel of the bridge's own map, loaded with the first such map. */
  #map(bridge: BridgeState): TemplateResult | typeof nothing {
    if (!bridge.map || bridge.connection !== "open") return nothing;
    this.#ofMap ??= bundle(this.store, "bridge_map.js", "What tells of the bridge's map").then((part) => {
      this.#renderMap = (part as typeof import("./bridge_map.js") | null)?.render ?? null;
      this.requestUpdate();
    });
    return this.#renderMap?.({ bridge, map: bridge.map, store: this.store, client: this.client }) ?? nothing;
  }
}

/** Shown only while the bridge is connected: later it would be stale. */
function state(bridge: BridgeState): TemplateResult {
  return html`<ul aria-label="Devices">${bridge.devices.map(device)}</ul>
      <dl>
        ${figure("Battery", unit(bridge.battery, 1, "V"), "bridge-battery")}
        ${figure("Delay", unit(1000 * bridge.roundTrip, 1, "ms"), "bridge-delay", "From this page to the bridge and back")}
        ${figure("Data age", unit(1000 * bridge.readingAge, 0, "ms"), "bridge-data-age", "Age of the robot's newest reading at the bridge")}
        ${figure("Missed", String(bridge.dropped), "bridge-missed", "Readings that this page was too slow for; newer ones came instead")}
        ${figure("Watching", String(bridge.watchers), "bridge-watching", "Pages that are connected, this one included")}
        ${figure("Drives", bridge.driver || "nobody", "bridge-driver")}
        <div class="wide" title="As whom this page is connected, and what it may do"><dt>You are</dt><dd data-testid="bridge-right">${bridge.right || bridge.role}: ${ROLES[bridge.role]}</dd></div>
        ${bridge.recording ? html`<div class="wide" title="Messages that stand in the file"><dt>Records</dt><dd data-testid="recording">${bridge.recording} · ${bridge.recorded} messages</dd></div>` : ""}
      </dl>`;
}

function sentence(bridge: BridgeState): string {
  if (bridge.connection === "connecting") return bridge.fault ? t`${bridge.fault} Trying again…` : "Connecting…";
  if (bridge.connection === "lost") return t`${bridge.fault} Trying again; the map stays.`;
  if (bridge.connection === "refused") return bridge.fault;
  if (bridge.emergency) return t`Emergency stop: the motors are cut off. ${undoing(bridge)}`;
  if (bridge.armed) return "You drive. The robot moves on command, and stops when this page is out of sight.";
  const why = bridge.reason && REASONS[bridge.reason];
  const stands = why ? t`The robot stands: ${why}.` : t`${bridge.driver ? t`“${bridge.driver}” drives the robot` : "The robot is driven"}; whoever has this page open may stop it.`;
  return bridge.mayDrive ? stands : t`${stands} This page only watches: ${bridge.right ? t`so says the right of ${bridge.right}` : "it has no token"}.`;
}

function undoing({ mayDrive, hasLease }: BridgeState): string {
  if (!mayDrive) return "Only a page that may drive can undo it.";
  return t`${hasLease ? "Undo it below" : "Press Drive, then undo it below"}; nothing moves by that.`;
}

function device(d: DeviceStatus): TemplateResult {
  const state = STATES[d.state];
  return html`<li><i class=${state.tone} aria-hidden="true"></i><span>${d.model || d.name}</span><span class="muted">${state.word}</span>
    ${d.model ? html`<small>${d.name}</small>` : ""}${d.detail ? html`<small>${d.detail}</small>` : ""}</li>`;
}

function unit(value: number, digits: number, name: string): string {
  return Number.isFinite(value) ? `${fixed(value, digits)} ${name}` : DASH;
}

customElements.define("slam-bridge", SlamBridge);
