// The run from its beginning to its furthest time: its events, the present moment, and a way back
// to earlier ones.

import { css, nothing, type TemplateResult } from "lit";
import { span } from "../past.js";
import { html, svg } from "../words.js";
import { SlamElement } from "./element.js";
import { clock } from "./format.js";
import { icons } from "./icons.js";
import { valueOf } from "./input.js";

/** A run shorter than this, s, needs no time line. */
const SHORTEST = 1;
/** The line grows by this at a time, s, while a run goes on. */
const GROWTH = 1;

export class SlamTimeline extends SlamElement {
  static override styles = css`
    :host { width: 100%; min-width: 0; }
    div.line { display: flex; align-items: center; gap: 10px; padding: 2px 12px 2px 4px; border: 1px solid var(--line); border-radius: 12px; background: var(--glass); box-shadow: var(--shadow); }
    .track { position: relative; flex: 1; min-width: 0; height: 30px; }
    input { position: absolute; inset: 0; width: 100%; height: 100%; margin: 0; accent-color: var(--accent); cursor: pointer; }
    /* As the handle runs: half its width from either end. */
    .track svg { position: absolute; left: 8px; top: 0; width: calc(100% - 16px); height: 12px; overflow: visible; pointer-events: none; }
    .track rect { fill: var(--good); transform: translateX(-1.5px); }
    .track rect.warn { fill: var(--warn); }
    .back svg { width: 20px; height: 20px; }
    .back { width: 36px; min-height: 32px; border-color: transparent; background: transparent; }
    .num { font: 500 12px/1 var(--mono); white-space: nowrap; color: var(--muted); }
    .num b { color: var(--ink); font-weight: 500; }
    .compare { min-height: 32px; padding: 0 9px; border-color: transparent; background: transparent; }
    @media (max-width: 760px) { .compare span { display: none; } div.line { border-radius: 0; border-width: 1px 0 0; box-shadow: none; } .back { width: 44px; min-height: 36px; } }
  `;

  protected override readonly topics = ["frame", "run", "log"] as const;
  /** Time at the handle while it is dragged, s. */
  #dragged: number | null = null;
  /** What was last shown, s: on the way to another moment the run has no status for a while. */
  #shown = { at: 0, whole: 0 };
  /** The length of the line, s. While a run goes on, its handle stays at the end: the line grows
      with it, but not with each scan, because no pixel of it would move. */
  #line = 0;

  override render(): TemplateResult | typeof nothing {
    const { store, client } = this;
    const { status, marks, seeking } = store;
    // A run that is repeated keeps its furthest time. Meanwhile the line stays, and so does the
    // focus of keyboard users: on the page the same keys would drive.
    if (!status && store.furthest === 0) this.#shown = { at: 0, whole: 0 };
    const whole = status ? span(store) : this.#shown.whole;
    if (store.source === "bridge" || store.reading || whole < SHORTEST) return nothing;
    const at = this.#dragged ?? seeking ?? status?.time ?? this.#shown.at;
    this.#shown = { at, whole };
    const goesOn = store.playing && at === whole && whole >= this.#line && whole - this.#line < GROWTH;
    if (!goesOn) this.#line = whole;
    const line = this.#line;
    const place = (time: number): string => `${100 * Math.min(time / line, 1)}%`;
    return html`<div class="line" role="group" aria-label="Past" aria-busy=${seeking !== null}>
      <button class="back icon" data-testid="back" aria-label="Back one scan" title="Back one scan (B)" @click=${this.press(() => client.back())}>${icons.back}</button>
      <span class="track">
        <input type="range" data-testid="timeline" min="0" max=${line} step="any" .value=${String(Math.min(at, line))} aria-label="Moment of the run" aria-valuetext="${clock(at)} of ${clock(whole)}"
          title="Drag to go back. From there the run goes the same way again, until you do something else"
          @input=${(e: Event) => this.#drag(Number(valueOf(e)))} @change=${(e: Event) => this.#drop(Number(valueOf(e)))}>
        <svg aria-hidden="true">${marks.map((mark) => svg`<rect class=${mark.level} x=${place(mark.time)} y="3" width="3" height="7" rx="1.5"/>`)}</svg>
      </span>
      <span class="num"><b>${clock(at)}</b> / ${clock(whole)}</span>
      <button class="compare" data-testid="compare" aria-label="Compare with…" title="Compare with other methods or settings, side by side (C)" @click=${() => dispatchEvent(new Event("show-race"))}>${icons.beside}<span>Compare</span></button>
    </div>`;
  }

  #drag(time: number): void {
    this.#dragged = time;
    this.requestUpdate();
  }

  #drop(time: number): void {
    this.#dragged = null;
    this.client.seek(time === this.#line ? this.#shown.whole : time);
  }
}

customElements.define("slam-timeline", SlamTimeline);
