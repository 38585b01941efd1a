// The tabs: on a phone all panels share one sheet; on a wide screen plots, filter, paths, settings
// and log share the rest of the side.

import { css, type TemplateResult } from "lit";
import { narrowScreen } from "../screen.js";
import type { Tab } from "../store.js";
import { html } from "../words.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";

const TABS: readonly { tab: Exclude<Tab, "">; label: string; icon: TemplateResult; phoneOnly?: boolean; narrowOnly?: boolean }[] = [
  { tab: "run", label: "Run", icon: icons.flag, phoneOnly: true },
  { tab: "status", label: "Status", icon: icons.gauge, phoneOnly: true },
  { tab: "plots", label: "Plots", icon: icons.chart },
  { tab: "filter", label: "Filter", icon: icons.matrix },
  { tab: "paths", label: "Paths", icon: icons.route },
  { tab: "settings", label: "Settings", icon: icons.sliders },
  { tab: "layers", label: "Layers", icon: icons.layers, narrowOnly: true },
  { tab: "log", label: "Log", icon: icons.list },
];

export class SlamTabs extends SlamElement {
  static override styles = css`
    nav { display: flex; background: var(--surface); border-top: 1px solid var(--line); padding-bottom: env(safe-area-inset-bottom); }
    /* Each as wide as its word: some languages have long ones. */
    button { flex: 1 1 auto; min-width: 40px; flex-direction: column; gap: 2px; min-height: 50px; padding: 0 3px; border: 0; border-radius: 0; background: transparent; font-size: 11px; color: var(--muted); }
    button[aria-pressed="true"] { color: var(--accent-ink); box-shadow: inset 0 2.5px 0 var(--accent); }
    /* Words of other languages run into one another where the screen is narrow. */
    @media (max-width: 400px) { button:not(:lang(en)) { min-width: 0; font-size: 10px; letter-spacing: -.01em; } }
    @media (min-width: 761px) {
      nav { padding: 0 3px; border-bottom: 1px solid var(--line); border-top: 0; }
      .phone { display: none; }
      .narrow { display: none; }
      button { flex-direction: row; gap: 4px; min-height: 42px; font-size: 13px; }
      button svg { width: 15px; height: 15px; }
      button[aria-pressed="true"] { box-shadow: inset 0 -2.5px 0 var(--accent); }
    }
    /* Where there is no room for the layers on the map. */
    @media (min-width: 761px) and (max-width: 1179px), (min-width: 761px) and (max-height: 560px) {
      nav { padding: 0; }
      .narrow { display: flex; }
      button { padding: 0 6px; gap: 4px; }
      button svg { display: none; }
    }
  `;

  protected override readonly topics = ["tab"] as const;
  #narrow = narrowScreen();

  override connectedCallback(): void {
    super.connectedCallback();
    this.#narrow.addEventListener("change", () => this.requestUpdate());
  }

  override render(): TemplateResult {
    const { store } = this;
    document.body.dataset["tab"] = store.tab;
    return html`<nav aria-label="Panels">
      ${TABS.map((t) => html`<button class=${t.phoneOnly ? "phone" : t.narrowOnly ? "narrow" : ""} data-testid="tab-${t.tab}" aria-pressed=${this.#isShown(t.tab)}
        @click=${() => this.#choose(t.tab)}>${t.icon}${t.label}</button>`)}
    </nav>`;
  }

  /** On a wide screen one of the five panels is always shown, with the layers beside it. */
  #isShown(tab: Tab): boolean {
    const { tab: chosen } = this.store;
    if (this.#narrow.matches || chosen === tab) return chosen === tab;
    const isPanel = TABS.some((t) => t.tab === chosen && !t.phoneOnly && !t.narrowOnly);
    return tab === "plots" && !isPanel;
  }

  #choose(tab: Tab): void {
    const isBeside = this.#narrow.matches || tab === "layers";
    const closes = this.store.tab === tab && isBeside;
    this.store.set("tab", { tab: closes ? "" : tab });
    // Scroll after the panel has taken up its room. The tabs themselves are visible already.
    if (!isBeside) requestAnimationFrame(() => document.querySelector(`#${tab}-panel`)?.scrollIntoView({ block: "start" }));
  }
}

customElements.define("slam-tabs", SlamTabs);
