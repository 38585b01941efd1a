// A label over the map of a run: its name, its present state, and a button to end it.

import { css, type TemplateResult } from "lit";
import { SlamElement } from "../ui/element.js";
import { clock, fixed } from "../ui/format.js";
import { icons } from "../ui/icons.js";
import type { PaletteName } from "../view/palette.js";
import { html, t } from "../words.js";
import { swatch } from "./swatch.js";

export class SlamRaceChip extends SlamElement {
  static override styles = css`
    :host { position: absolute; left: 8px; top: 8px; max-width: calc(100% - 16px); z-index: 1; }
    :host([shown]) { max-width: calc(100% - 66px); }
    div { display: flex; align-items: center; gap: 8px; width: max-content; max-width: 100%; min-height: 30px; padding: 0 4px 0 10px; border: 1px solid var(--line); border-radius: 9px; background: var(--glass); font-size: 13px; }
    b { font-weight: 600; overflow: hidden; text-overflow: ellipsis; white-space: nowrap; }
    .now { display: var(--chip-now, inline); margin-right: 6px; font: 500 12px/1 var(--mono); color: var(--muted); white-space: nowrap; }
    button { min-height: 28px; padding: 0 7px; border-color: transparent; background: transparent; }
    button svg { width: 15px; height: 15px; }
    svg.line { width: 20px; height: 8px; }
    @media (max-width: 1179px), (max-height: 560px) { .layers { display: none; } }
    /* The name goes first; the figures stand under Plots as well. */
    @media (min-width: 761px) and (max-width: 1000px) { .now { display: none; } }
    @media (pointer: coarse) { button { min-height: 40px; min-width: 40px; } }
    @media (max-width: 760px) { :host { left: 4px; top: 4px; } div { font-size: 12px; gap: 6px; padding-left: 8px; } }
  `;

  protected override readonly topics = ["frame", "run", "tab"] as const;
  name = "";
  colour: PaletteName = "estimate";
  /** Its index among the runs. */
  place = 0;
  onClose: (() => void) | null = null;
  /** Whether it has caught up with the others. */
  isThere = (): boolean => true;

  override render(): TemplateResult {
    const { status, reading } = this.store;
    const error = status?.positionError ?? NaN;
    const now = reading || !status ? "begins …" : !this.isThere() ? t`on the way, ${clock(status.time)}` : Number.isFinite(error) ? `${fixed(error, 3)} m` : clock(status.time);
    return html`<div >${swatch(this.colour, this.place)}<b title=${this.name}>${this.name}</b>
      <span class="now" data-testid="race-now-${this.place}" title=${Number.isFinite(error) ? "Position error" : "Moment of the recording"}>${now}${status?.finished ? " · over" : ""}</span>
      ${this.onClose ? html`<button data-testid="race-close-${this.place}" aria-label="End ${this.name}" title="End this run; the others go on" @click=${this.onClose}>${icons.close}</button>` : html`<button class="layers" data-testid="race-layers" aria-label="Layers" aria-pressed=${this.store.tab === "layers"} title="What the maps show" @click=${() => this.#toggleLayers()}>${icons.layers}</button>`}</div>`;
  }

  #toggleLayers(): void {
    this.store.set("tab", { tab: this.store.tab === "layers" ? "plots" : "layers" });
  }
}

customElements.define("slam-race-chip", SlamRaceChip);
