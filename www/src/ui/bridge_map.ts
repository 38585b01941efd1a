// The bridge's own map: how it does, and that it can be begun anew. A bundle of its own, which
// comes with the first bridge that maps.

import { nothing, type TemplateResult } from "lit";
import type { BridgeMapStatus } from "../protocol/module.js";
import type { BridgeState } from "../protocol/devices.js";
import type { Client } from "../client.js";
import { html, t } from "../words.js";

export function render(bridge: BridgeState, map: BridgeMapStatus, client: Client): TemplateResult {
  const kept = map.file ? t`kept in ${map.file}` : "gone with the bridge: it is kept in no file";
  return html`
    <p data-testid="bridge-map">The bridge maps, too: ${map.scans} scans by ${map.method}, ${kept}. ${map.place ? "Its walls are drawn beside this page's map." : "It is not known yet how its map lies to this page's."}</p>
    ${map.fault ? html`<p role="alert" data-testid="bridge-map-fault">${map.fault}.</p>` : nothing}
    ${bridge.mayDrive ? html`<button data-testid="bridge-map-reset" title="The map before stays in a file of its own beside the new one, where the bridge keeps one" @click=${() => anew(client)}>Begin the bridge's map anew</button>` : nothing}`;
}

function anew(client: Client): void {
  if (confirm("Begin the bridge's own map anew, from where the robot stands?")) client.resetBridgeMap();
}
