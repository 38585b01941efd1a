// A robot at a serial port of this computer, without a bridge: chosen here, driven like any other.

import { css, type TemplateResult } from "lit";
import { webSerial } from "../serial_ports.js";
import { html } from "../words.js";
import { SlamElement } from "./element.js";
import { isChecked } from "./input.js";
import { tool } from "./style.js";

export class SlamCable extends SlamElement {
  static override styles = [tool, css`:host { margin-top: 0; } .row { display: flex; flex-wrap: wrap; gap: 8px; margin: 4px 0 10px; } .row button { flex: 1 1 90px; }`];

  protected override readonly topics = ["bridge", "run"] as const;

  /** The browser has to offer every port, not only those of the device's usual adapters. */
  #ofAll = false;

  override render(): TemplateResult {
    const { plugged } = this.client.robot;
    return html`<details data-testid="cable" ?open=${plugged.length > 0}>
      <summary>Robot at a cable of this computer</summary>
      ${webSerial()
        ? html`<p>Choose what is plugged in; the browser then asks for its port. Several devices work together. The robot stands until you press Drive, and stops when this page is out of sight.</p>
          <div class="row">${this.store.offer.devices.map((kind) => html`<button data-testid="plug-${kind.name}" title=${kind.about} aria-pressed=${plugged.includes(kind.name)} @click=${() => void this.client.robot.plug(kind, this.#ofAll)}>${kind.title}</button>`)}</div>
          <label><input type="checkbox" data-testid="all-ports" .checked=${this.#ofAll} @change=${(e: Event) => (this.#ofAll = isChecked(e))}> Offer every port, also those of other adapters</label>
          ${plugged.length > 0 ? html`<div class="row"><button data-testid="unplug" @click=${() => this.client.start({ mode: "explore" })}>Leave the robot</button></div>` : ""}`
        : html`<p data-testid="no-web-serial">This browser has no Web Serial. Chrome, Edge and Opera on a computer have, where the page's address begins with https or is this computer's own. In all others use the bridge on the robot.</p>`}
    </details>`;
  }
}

customElements.define("slam-cable", SlamCable);
