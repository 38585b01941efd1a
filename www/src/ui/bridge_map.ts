// The bridge's own map: its state, a button to restart it, and where in it the robot may be. A
// bundle of its own, loaded with the first bridge that maps.

import { nothing, type TemplateResult } from "lit";
import { closed, type FenceDraft, undone } from "../fence.js";
import type { BridgeMapStatus, FenceStateName } from "../protocol/module.js";
import type { BridgeState } from "../protocol/devices.js";
import type { Client } from "../client.js";
import type { Store } from "../store.js";
import { html, t } from "../words.js";

interface Here {
  readonly bridge: BridgeState;
  readonly map: BridgeMapStatus;
  readonly store: Store;
  readonly client: Client;
}

/** The robot's position relative to its geofence. */
const FENCE: Readonly<Record<FenceStateName, string>> = {
  off: "No geofence: the robot may go everywhere.",
  within: "The robot is within its geofence.",
  held: "The geofence holds the robot back. It goes wherever that brings it no nearer to the border.",
  outside: "The robot is outside its geofence. Armed, it goes back in, and no other way.",
  "no-pose": "There is a geofence, and it is not known where the robot is: it does not drive. Push it about by hand until it finds itself in the map, or let an owner lift the geofence.",
};

export function render(here: Here): TemplateResult {
  const { bridge, map, client, store } = here;
  const kept = map.file ? t`kept in ${map.file}` : "gone with the bridge: it is kept in no file";
  const isFault = map.fenceState !== "off" && map.fenceState !== "within";
  return html`
    <p data-testid="bridge-map">The bridge maps, too: ${map.scans} scans by ${map.method}, ${kept}. ${map.place ? "Its walls are drawn beside this page's map." : "It is not known yet how its map lies to this page's."}</p>
    ${map.fault ? html`<p role="alert" data-testid="bridge-map-fault">${map.fault}.</p>` : nothing}
    <p role=${isFault ? "alert" : "status"} data-testid="geofence">${FENCE[map.fenceState]}</p>
    ${store.fence ? drawing(here, store.fence) : html`<p class="row">
      ${bridge.role === "owner" ? html`<button data-testid="geofence-draw" ?disabled=${!map.place} title="Where the robot may be, corner by corner" @click=${() => begin(here)}>${map.geofence.zones.length > 0 ? "Change the geofence" : "Draw a geofence"}</button>` : nothing}
      ${bridge.role === "owner" && map.fenceState === "no-pose" ? html`<button data-testid="geofence-lift" title="The robot may drive everywhere then, and so finds itself; draw the geofence again after that" @click=${() => lift(client)}>Lift the geofence</button>` : nothing}
      ${bridge.mayDrive ? html`<button data-testid="bridge-map-reset" title="The map before stays in a file of its own beside the new one, where the bridge keeps one" @click=${() => anew(client)}>Begin the bridge's map anew</button>` : nothing}
    </p>`}`;
}

function begin({ store, map }: Here): void {
  store.set("run", { fence: { keepOut: false, zones: map.geofence.zones, corners: [] }, editing: null, inspecting: false, aiming: false });
}

function drawing({ store, client }: Here, fence: FenceDraft): TemplateResult {
  const set = (fence: FenceDraft | null): void => store.set("run", { fence });
  const { corners, zones, keepOut } = fence;
  const done = (): void => {
    client.robot.setGeofence((corners.length > 0 ? closed(fence) : fence).zones);
    set(null);
  };
  return html`<fieldset data-testid="geofence-editor">
    <legend>Geofence</legend>
    <p aria-live="polite">${corners.length === 0 ? areas(zones.length) : cornersOf(corners.length)}</p>
    <p class="row">
      <label><input type="radio" name="zone" .checked=${!keepOut} @change=${() => set({ ...fence, keepOut: false })}> stays in</label>
      <label><input type="radio" name="zone" data-testid="geofence-keep-out" .checked=${keepOut} @change=${() => set({ ...fence, keepOut: true })}> keeps out</label>
    </p>
    <p class="row">
      <button data-testid="geofence-undo" ?disabled=${corners.length + zones.length === 0} @click=${() => set(undone(fence))}>Undo</button>
      <button data-testid="geofence-close" ?disabled=${corners.length < 3} @click=${() => set(closed(fence))}>Close the area</button>
      <button data-testid="geofence-clear" ?disabled=${corners.length + zones.length === 0} @click=${() => set({ ...fence, zones: [], corners: [] })}>Clear</button>
    </p>
    <p class="row">
      <button data-testid="geofence-set" ?disabled=${corners.length === 1 || corners.length === 2} @click=${done}>${zones.length + corners.length === 0 ? "Set none" : "Set it"}</button>
      <button data-testid="geofence-cancel" @click=${() => set(null)}>Cancel</button>
    </p>
  </fieldset>`;
}

function anew(client: Client): void {
  if (confirm(t("Begin the bridge's own map anew, from where the robot stands? Its geofence is gone with it."))) client.robot.resetMap();
}

function lift(client: Client): void {
  if (confirm(t("Lift the geofence? The robot may drive everywhere then. It is to be drawn again once the robot has found itself."))) client.robot.setGeofence([]);
}

function areas(count: number): string {
  if (count === 0) return t("No area yet. Tap the map to put the corners of one; Enter puts one at the cross.");
  const found = count === 1 ? t("One area") : t`${count} areas`;
  return t`${found}. Tap the map to put the corners of another; Enter puts one at the cross.`;
}

function cornersOf(count: number): string {
  const found = count === 1 ? t`${count} corner` : t`${count} corners`;
  return count < 3 ? t`${found}; an area has three at least.` : `${found}.`;
}
