// Name, a sentence on what is happening, registration lab, theme and help.

import { css, type TemplateResult } from "lit";
import { isInDoubt } from "../view/layers/grid.js";
import { isDark, switchTheme } from "../theme.js";
import { html, t } from "../words.js";
import { caption } from "./caption.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";

export class SlamHeader extends SlamElement {
  static override styles = css`
    :host { display: flex; align-items: center; gap: 18px; padding: 0 14px 0 18px; height: 100%; }
    .brand { display: flex; align-items: center; gap: 10px; font: 650 19px/1 var(--sans); letter-spacing: -.02em; }
    .brand b { font-weight: 650; color: var(--accent-ink); }
    .brand svg { width: 26px; height: 26px; stroke: none; }
    .caption { flex: 1; min-width: 0; display: flex; align-items: center; gap: 10px; font-size: 14.5px; }
    .caption p { margin: 0; overflow: hidden; line-height: 1.3; display: -webkit-box; -webkit-line-clamp: 2; -webkit-box-orient: vertical; }
    .caption strong { font-weight: 600; }
    .dot { width: 9px; height: 9px; border-radius: 50%; background: var(--muted); flex: none; }
    /* It does not beat: an animation costs style, layout and paint for each picture of the map. */
    .dot.on { background: var(--good); box-shadow: 0 0 0 4px color-mix(in srgb, var(--good) 22%, transparent); }
    .dot.off { background: var(--warn); }
    .tools { display: flex; gap: 6px; }
    .tools button { border-color: transparent; background: transparent; }
    .tools button:hover { background: var(--hover); }
    @media (max-width: 760px) {
      :host { gap: 10px; padding: 0 6px 0 12px; }
      .brand span { display: none; }
      .caption { font-size: 13px; }
      .tools { gap: 0; }
    }
    /* On a narrow phone the sentence needs the room: the tools of the map have the same switch. */
    @media (max-width: 480px) {
      .tools [data-testid="peek"] { display: none; }
      /* "Explored: nothing" is another sentence than "Explored: nothing unknown is left". */
      :host { gap: 6px; padding: 0 2px 0 10px; }
      .caption { gap: 8px; font-size: 12px; }
      .caption p { line-height: 1.2; -webkit-line-clamp: 3; }
      /* What is seen in each icon of the page a long sentence may do without. */
      :host([long]) .brand { position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%); }
      :host([long]) .caption { font-size: 11.5px; }
      :host([long]) .caption p { line-height: 1.1; -webkit-line-clamp: 4; }
    }
  `;

  protected override readonly topics = ["frame", "run", "theme", "bridge", "quality", "view"] as const;

  override render(): TemplateResult {
    const { store } = this;
    const words = caption(store);
    const dark = isDark(store);
    this.toggleAttribute("long", t(words.doing).length > LONG);
    const goes = store.playing && !(store.source === "sim" && store.isStopped && store.status?.mode === "manual");
    return html`
      <h1 class="brand" aria-label="slamlab">
        <svg viewBox="0 0 32 32" aria-hidden="true"><g fill="none" stroke="var(--map-truth)" stroke-width="1.8" stroke-linecap="round"><path d="M12 20 6 8M12 20 14 5M12 20 23 8M12 20l15-3" opacity=".8"/></g><path d="M5 6.5 14 4l10 3 4 10" fill="none" stroke="currentColor" stroke-width="2.4" stroke-linejoin="round" stroke-linecap="round"/><circle cx="12" cy="20" r="6" fill="var(--map-estimate)"/></svg>
        <span>slam<b>lab</b></span>
      </h1>
      <div class="caption" data-testid="caption">
        <i class="dot ${store.isCutOff || (store.status !== null && isInDoubt(store.status)) ? "off" : goes ? "on" : ""}"></i>
        <p><strong>${words.doing}</strong>${words.more ? html` <span class="muted">· ${inOnePiece(words.more)}</span>` : ""}</p>
      </div>
      <div class="tools">
        <button class="icon" aria-label="Experiments" title="Experiments: runs in which one thing is seen (G)" data-testid="show-gallery"
          @click=${() => this.dispatchEvent(new CustomEvent("show-gallery", { bubbles: true, composed: true }))}>${icons.flask}</button>
        <button class="icon" aria-label="Registration lab" title="Registration lab: two scans on each other (L)" data-testid="registration"
          @click=${() => this.dispatchEvent(new CustomEvent("show-registration", { bubbles: true, composed: true }))}>${icons.scans}</button>
        ${store.source === "sim" ? html`<button class="icon" aria-label="Truth" aria-pressed=${store.layers.truth} title=${store.layers.truth ? "Hide the truth: the real walls and the real pose (X)" : "Show the truth: the real walls and the real pose (X)"} data-testid="peek"
          @click=${this.press(() => store.toggleLayer("truth"))}>${store.layers.truth ? icons.eye : icons.hidden}</button>` : ""}
        <button class="icon" aria-label=${dark ? "Light theme" : "Dark theme"} title=${dark ? "Light theme (T)" : "Dark theme (T)"} data-testid="theme"
          @click=${this.press(() => switchTheme(store))}>${dark ? icons.sun : icons.moon}</button>
        <button class="icon" aria-label="Help" title="Help (?)" data-testid="help"
          @click=${() => this.dispatchEvent(new CustomEvent("show-help", { bubbles: true, composed: true }))}>${icons.help}</button>
      </div>
    `;
  }
}

/** Letters above which a sentence needs more than three lines on a narrow phone. */
const LONG = 48;

/** Keeps numbers and their units on one line. */
const inOnePiece = (text: string): string => t(text).replace(/(\d) (?=[a-z%]+\b|%)/g, "$1\u00a0");

customElements.define("slam-header", SlamHeader);
