// For a robot that has a computer of its own: where to get the bridge, and a field for its address.

import { css, nothing, type TemplateResult } from "lit";
import type { Host } from "../bridge_address.js";
import { bundle } from "../bundle.js";
import { html, t } from "../words.js";
import { withCode } from "./code.js";
import { SlamElement } from "./element.js";
import { tool } from "./style.js";

/** Where to get the bridge, depending on what serves this page. */
const WHERE: Readonly<Record<Host, string>> = {
  bridge: "This page comes from a bridge that has no robot: with `--source` it is told where one is.",
  files: "A robot with a computer of its own has a bridge there, which serves this same page with the robot behind it: open the bridge's address. This copy of the page stands on a server of files, and no bridge can be reached from it.",
  other: "A robot with a computer of its own has a bridge there, which serves this same page with the robot behind it: open the bridge's address.",
  silent: "The server of this page cannot be reached: it is shown as the browser keeps it. If a bridge serves it, its robot is there again when the bridge is, after a reload.",
};

export class SlamElsewhere extends SlamElement {
  static override styles = [tool, css`:host { margin-top: 0; }`];

  protected override readonly topics = ["bridge", "run"] as const;
  #canAsk = false;

  override render(): TemplateResult | typeof nothing {
    const { host, source } = this.store;
    this.toggleAttribute("hidden", source === "bridge");
    if (source === "bridge") return nothing;
    return html`<details data-testid="elsewhere" @toggle=${this.#asks}>
      <summary>Robot behind a bridge</summary>
      ${host ? html`<p data-testid="no-bridge">${withCode(t(WHERE[host]))}</p>` : nothing}
      ${this.#canAsk ? html`<slam-bridge-address></slam-bridge-address>` : nothing}
    </details>`;
  }

  /** The field is loaded when somebody looks for it. */
  readonly #asks = async (event: Event): Promise<void> => {
    const isOpen = (event.currentTarget as HTMLDetailsElement).open;
    this.#canAsk = isOpen && (await bundle(this.store, "bridge_field.js", "The field for an address")) !== null;
    this.requestUpdate();
  };
}

customElements.define("slam-elsewhere", SlamElsewhere);
