// A robot at a serial port of this computer, without a bridge: chosen here, driven like any other.

import { css, html, type TemplateResult } from "lit";
import type { SerialKind } from "../protocol/devices.js";
import { webSerial } from "../serial_ports.js";
import type { Topic } from "../store.js";
import { SlamElement } from "./element.js";
import { shared, tool } from "./style.js";

const KINDS: readonly { kind: SerialKind; label: string; meaning: string }[] = [
  { kind: "rp6", label: "RP6", meaning: "The robot, with the firmware of this project: it drives, counts and looks with its rangers." },
  { kind: "rplidar", label: "RPLIDAR", meaning: "A lidar of SLAMTEC. With an RP6 it is the robot's eye; alone it is carried by hand." },
  { kind: "ld06", label: "LD06", meaning: "A lidar of LDROBOT, LD06 or LD19." },
];

export class SlamCable extends SlamElement {
  static override styles = [shared, tool, css`.row { display: flex; flex-wrap: wrap; gap: 8px; margin: 4px 0 10px; } .row button { flex: 1 1 90px; }`];

  protected override readonly topics: readonly Topic[] = ["bridge", "run"];

  override render(): TemplateResult {
    const plugged = this.client.plugged;
    return html`<details data-testid="cable" ?open=${plugged.length > 0}>
      <summary>Robot at a cable of this computer</summary>
      ${webSerial()
        ? html`<p>Choose what is plugged in; the browser then asks for its port. Several devices work together. The robot stands until you press Drive, and stops when this page is out of sight.</p>
          <div class="row">${KINDS.map((k) => html`<button data-testid="plug-${k.kind}" title=${k.meaning} aria-pressed=${plugged.includes(k.kind)} @click=${() => void this.client.plug(k.kind)}>${k.label}</button>`)}</div>
          ${plugged.length > 0 ? html`<div class="row"><button data-testid="unplug" @click=${() => this.client.start({ mode: "explore" })}>Leave the robot</button></div>` : ""}`
        : html`<p data-testid="no-web-serial">This browser has no Web Serial. Chrome, Edge and Opera on a computer have, where the page's address begins with https or is this computer's own. In all others use the bridge on the robot.</p>`}
    </details>`;
  }
}

customElements.define("slam-cable", SlamCable);
