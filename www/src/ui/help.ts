// The help: what the page shows, and every key.

import { css, nothing, type TemplateResult } from "lit";
import { bundle } from "../bundle.js";
import type { Offline } from "../offline.js";
import { isTouched } from "../screen.js";
import { begin } from "../tour.js";
import { html } from "../words.js";
import { dialog, SlamDialog } from "./dialog.js";
import { icons } from "./icons.js";

/** Whether the page opens without its server. */
const OFFLINE: Readonly<Record<Offline["kind"], string>> = {
  kept: "This page is kept by the browser: it opens and runs without its server, as out of doors at a robot",
  storing: "This page is about to be kept by the browser; from then on it opens without its server",
  none: "This page needs its server each time that it is opened",
};

const KEYS: readonly (readonly [string, string])[] = [
  ["Arrow keys, W A S D", "drive by hand while held"],
  ["Gamepad", "left stick drives; B or the right trigger stops"],
  ["Space, Esc", "Stop"],
  ["P", "play or pause"],
  ["N, B", "one scan on, one scan back"],
  ["[ ]", "slower, faster"],
  ["1 2 3", "Manual, Go to, Explore"],
  ["4", "the cycle: scan standing, plan, one turn, one leg"],
  [".", "in the cycle: the next stage"],
  ["Enter", "with the map in focus: go to the cross in the middle"],
  ["Shift + arrow keys", "with the map in focus: move the view"],
  ["+ − 0", "zoom in, zoom out, show everything"],
  ["Q, Shift + Q, J", "turn the map to the left, to the right, upright again; so do a drag with Shift, and two fingers"],
  ["F", "follow the robot"],
  ["I", "inspect: a click, or Enter at the cross, tells what is there, again what lies under it; Esc ends it"],
  ["E", "change the map by hand: a drag erases or draws, and so do two clicks, or Enter twice with the map in focus (scan matching)"],
  ["R", "start again"],
  ["Y, M, Shift + A", "save: one file, or several in one archive; A alone steers to the left, and saves where there is nothing to steer: in a recording"],
  ["K", "copy the link of this run"],
  ["O", "draw a world of your own, and let the robot map it"],
  ["L", "the registration lab: two scans on each other, by every method"],
  ["X", "show or hide the truth, which only a simulator knows"],
  ["C", "compare with other methods or settings, side by side"],
  ["G", "the gallery of experiments"],
  ["T", "dark or light"],
  ["?", "this page"],
];

const FINGERS = [
  ["Tap", "the robot drives there; while things are inspected, says what is there"],
  ["Drag", "moves the view"],
  ["Two fingers", "zoom and turn the map"],
  ["Stick", "in Manual: drives as long as the thumb is down"],
];

export class SlamHelp extends SlamDialog {
  static override styles = [dialog, css`
    h2 { margin: 20px 0 8px; }
    dl { display: grid; grid-template-columns: auto 1fr; gap: 5px 18px; margin: 0; font-size: 13.5px; }
    dt { font-family: var(--mono); font-size: 12.5px; }
    dd { margin: 0; color: var(--muted); }
  `];

  protected override readonly topics = ["offline"] as const;

  /** Visitors who want another language look here. */
  override show(): void {
    super.show();
    void bundle(this.store, "language.js", "The choice of the language");
  }

  override render(): TemplateResult {
    return html`<dialog aria-labelledby="title" data-testid="help-dialog" @click=${(e: Event) => e.target === e.currentTarget && this.close()}>
      <header><h3 id="title">A robot that has never been here</h3><button class="icon" aria-label="Close" @click=${() => this.close()}>${icons.close}</button></header>
      <p>It starts with an empty map and does not know where it is. Its wheels count the way, and err a little with every turn. Its sensor measures the distance to the walls, and errs too.</p>
      <p>From both it works out the walls and its own place in one go: <b>SLAM</b>, simultaneous localisation and mapping. The orange ellipse says how sure it is. It swells on the way into the unknown, and shrinks when a wall is met again. The dotted trail shows where the robot would believe to be by its wheels alone.</p>
      <p><button data-testid="tour-begin" @click=${() => this.#tour()}>${icons.play} Watch it happen, in four steps</button></p>
      <p>Choose Go to and click the map: the robot drives there. While it explores, a click asks first. Drop a recorded log, and the same algorithms map a real building.</p>
      <p data-testid="offline">${OFFLINE[this.store.offline.kind]}${this.store.offline.kind === "none" ? html`: ${this.store.offline.why}` : ""}.</p>
      <slam-language .store=${this.store}></slam-language>
      ${isTouched() ? html`<h2>By finger</h2>
      <dl>${FINGERS.map(([touch, does]) => html`<dt>${touch}</dt><dd>${does}</dd>`)}</dl>` : nothing}
      <h2>Keys</h2>
      <dl>${KEYS.map(([key, does]) => html`<dt>${key}</dt><dd>${does}</dd>`)}</dl>
    </dialog>`;
  }

  #tour(): void {
    this.close();
    begin(this.store, this.client);
  }
}

customElements.define("slam-help", SlamHelp);
