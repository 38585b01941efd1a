// A robot at a serial port of this computer, without a bridge: chosen here, driven like any other.

import { css, type TemplateResult } from "lit";
import type { Host } from "../bridge_address.js";
import { webSerial } from "../serial_ports.js";
import { html, t } from "../words.js";
import { withCode } from "./code.js";
import { SlamElement } from "./element.js";
import { isChecked } from "./input.js";
import { tool } from "./style.js";

/** Where a robot that has a computer of its own is to be had, by what serves this page. */
const ELSEWHERE: Readonly<Record<Host, string>> = {
  bridge: "This page comes from a bridge that has no robot: with `--source` it is told where one is.",
  files: "A robot with a computer of its own has a bridge there, which serves this same page with the robot behind it: open the bridge's address. This copy of the page stands on a server of files, and no bridge can be reached from it.",
  other: "A robot with a computer of its own has a bridge there, which serves this same page with the robot behind it: open the bridge's address.",
  silent: "The server of this page cannot be reached: it is shown as the browser keeps it. If a bridge serves it, its robot is there again when the bridge is, after a reload.",
};

export class SlamCable extends SlamElement {
  static override styles = [tool, css`.row { display: flex; flex-wrap: wrap; gap: 8px; margin: 4px 0 10px; } .row button { flex: 1 1 90px; }`];

  protected override readonly topics = ["bridge", "run"] as const;

  /** The browser is to offer every port, not only those behind the device's usual adapters. */
  #ofAll = false;

  override render(): TemplateResult {
    const { client: { plugged }, store: { host, source } } = this;
    return html`<details data-testid="cable" ?open=${plugged.length > 0}>
      <summary>Robot at a cable of this computer</summary>
      ${webSerial()
        ? html`<p>Choose what is plugged in; the browser then asks for its port. Several devices work together. The robot stands until you press Drive, and stops when this page is out of sight.</p>
          <div class="row">${this.store.offer.devices.map((kind) => html`<button data-testid="plug-${kind.name}" title=${kind.about} aria-pressed=${plugged.includes(kind.name)} @click=${() => void this.client.plug(kind, this.#ofAll)}>${kind.title}</button>`)}</div>
          <label><input type="checkbox" data-testid="all-ports" .checked=${this.#ofAll} @change=${(e: Event) => (this.#ofAll = isChecked(e))}> Offer every port, also those of other adapters</label>
          ${plugged.length > 0 ? html`<div class="row"><button data-testid="unplug" @click=${() => this.client.start({ mode: "explore" })}>Leave the robot</button></div>` : ""}`
        : html`<p data-testid="no-web-serial">This browser has no Web Serial. Chrome, Edge and Opera on a computer have, where the page's address begins with https or is this computer's own. In all others use the bridge on the robot.</p>`}
      ${host && source !== "bridge" ? html`<p data-testid="no-bridge">${withCode(t(ELSEWHERE[host]))}</p>` : ""}
    </details>`;
  }
}

customElements.define("slam-cable", SlamCable);
