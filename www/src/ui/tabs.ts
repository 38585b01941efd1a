// On a phone the panels share one sheet; these choose which.

import { css, html, type TemplateResult } from "lit";
import type { Tab, Topic } from "../store.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";
import { shared } from "./style.js";

const TABS: readonly { tab: Exclude<Tab, "">; label: string; icon: TemplateResult }[] = [
  { tab: "run", label: "Run", icon: icons.sliders },
  { tab: "status", label: "Status", icon: icons.gauge },
  { tab: "plots", label: "Plots", icon: icons.chart },
  { tab: "layers", label: "Layers", icon: icons.layers },
  { tab: "log", label: "Log", icon: icons.list },
];

export class SlamTabs extends SlamElement {
  static override styles = [
    shared,
    css`
      nav { display: grid; grid-template-columns: repeat(5, 1fr); background: var(--surface); border-top: 1px solid var(--line); padding-bottom: env(safe-area-inset-bottom); }
      button { flex-direction: column; gap: 2px; min-height: 50px; padding: 0; border: 0; border-radius: 0; background: transparent; font-size: 11px; color: var(--muted); }
      button[aria-pressed="true"] { color: var(--accent-ink); box-shadow: inset 0 2.5px 0 var(--accent); }
    `,
  ];

  protected override readonly topics: readonly Topic[] = ["tab"];

  override render(): TemplateResult {
    const { store } = this;
    document.body.dataset["tab"] = store.tab;
    return html`<nav aria-label="Panels">
      ${TABS.map((t) => html`<button data-testid="tab-${t.tab}" aria-pressed=${store.tab === t.tab}
        @click=${() => store.set("tab", { tab: store.tab === t.tab ? "" : t.tab })}>${t.icon}${t.label}</button>`)}
    </nav>`;
  }
}

customElements.define("slam-tabs", SlamTabs);
