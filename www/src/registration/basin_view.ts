// The basin of convergence of a method: the starts from which it reaches the right pose, filled in
// as they are computed.

import { css, nothing, type TemplateResult } from "lit";
import type { BasinAxesName } from "../protocol/module.js";
import { word } from "../spoken.js";
import type { Column } from "../csv.js";
import "../ui/csv_button.js";
import { fixed } from "../ui/format.js";
import { icons } from "../ui/icons.js";
import { valueOf } from "../ui/input.js";
import { colourOf } from "../ui/plot_style.js";
import { html, t } from "../words.js";
import { LabElement } from "./element.js";
import { wordsOf } from "./methods.js";
import { type BasinMap, REACH } from "./model.js";
import { between } from "./pose.js";

const SIZES = [15, 25, 41] as const;
/** Colours of the outcomes, in the order of the core. */
const OUTCOMES = [
  { colour: "map-path", words: word("found") },
  { colour: "line-strong", words: "lost, and says so" },
  { colour: "map-torn", words: "lost, and sure of it" },
] as const;

export class LabBasin extends LabElement {
  static override styles = css`
    :host { display: flex; flex-direction: column; gap: 8px; padding: 12px 14px; border: 1px solid var(--line); border-radius: 14px; background: var(--raised); min-width: 0; }
    .row { display: flex; gap: 8px; flex-wrap: wrap; }
    .row > * { flex: 1 1 96px; }
    .row > :first-child { flex: 1.6 1 150px; }
    label { display: grid; gap: 3px; font-size: 12px; color: var(--muted); }
    select { color: var(--ink); font-size: 13px; min-width: 0; }
    .map { display: grid; grid-template: minmax(0, 1fr) auto / auto minmax(0, 1fr); gap: 3px 6px; flex: 1; min-height: 190px; }
    .up { writing-mode: vertical-rl; transform: rotate(180deg); display: flex; justify-content: space-between; font: 500 11px/1 var(--mono); color: var(--muted); }
    .right { grid-column: 2; display: flex; justify-content: space-between; font: 500 11px/1.2 var(--mono); color: var(--muted); }
    .picture { position: relative; box-shadow: inset 0 0 0 1px var(--line); border-radius: 6px; min-height: 0; }
    canvas { position: absolute; inset: 0; width: 100%; height: 100%; border-radius: 6px; cursor: crosshair; }
    .key { display: flex; gap: 4px 14px; flex-wrap: wrap; font-size: 12px; color: var(--muted); }
    .key span { display: flex; align-items: center; gap: 6px; }
    .key i { width: 10px; height: 10px; border-radius: 2px; }
    .key svg { width: 13px; height: 13px; stroke-width: 2; color: var(--ink); }
    .o0 { background: var(--map-path); } .o1 { background: color-mix(in srgb, var(--line-strong) 45%, transparent); } .o2 { background: var(--map-torn); }
    .go { display: flex; align-items: center; gap: 10px; }
    progress { flex: 1; min-width: 60px; height: 8px; accent-color: var(--accent); }
    p { margin: 0; font-size: 12.5px; line-height: 1.45; color: var(--muted); }
    .num { font-size: 12px; }
    @media (max-width: 760px) { .row > :first-child { flex-basis: 100%; } .map { min-height: 150px; } }
  `;

  #method = "point-to-line";
  #axes: BasinAxesName = "shift-turn";
  #cells = 25;

  override render(): TemplateResult {
    const { basin, offer, right } = this.model;
    const axes = basin?.axes ?? this.#axes;
    const { shift, turn } = basin ?? REACH;
    const up = axes === "place" ? `${shift} m` : `${Math.round((180 / Math.PI) * turn)}°`;
    const isRunning = basin?.state === "running";
    return html`
      <h2>Basin of convergence</h2>
      <div class="row">
        <label>Method<select data-testid="basin-method" @change=${(e: Event) => { this.#method = valueOf(e); this.requestUpdate(); }}>${(offer?.methods ?? []).map((name) => html`<option value=${name} .selected=${name === this.#method}>${wordsOf(name).title}</option>`)}</select></label>
        <label>Starts<select data-testid="basin-axes" @change=${(e: Event) => { this.#axes = valueOf(e) as BasinAxesName; this.requestUpdate(); }}><option value="shift-turn" .selected=${this.#axes === "shift-turn"}>shift × turn</option><option value="place" .selected=${this.#axes === "place"}>x × y</option></select></label>
        <label>Cells<select data-testid="basin-cells" @change=${(e: Event) => { this.#cells = Number(valueOf(e)); this.requestUpdate(); }}>${SIZES.map((size) => html`<option value=${size} .selected=${size === this.#cells}>${size} × ${size}</option>`)}</select></label>
      </div>
      <div class="map">
        <div class="up" aria-hidden="true"><span>−${up}</span><span>${axes === "place" ? "y" : "turn"}</span><span>+${up}</span></div>
        <div class="picture"><canvas role="img" data-testid="basin-map" aria-label=${this.#words(basin)} title="A click begins there" @click=${this.#begin}></canvas></div>
        <div class="right" aria-hidden="true"><span>−${shift} m</span><span>${axes === "place" ? "x" : "shift along x"}</span><span>+${shift} m</span></div>
      </div>
      <div class="key" aria-hidden="true">${OUTCOMES.map(({ words }, i) => html`<span><i class="o${i}"></i>${words}</span>`)}<span><svg viewBox="0 0 12 12"><path d="M6 1v10M1 6h10"/></svg>right pose</span><span><svg viewBox="0 0 12 12"><circle cx="6" cy="6" r="4.5"/></svg>start now</span></div>
      <div class="go">
        ${isRunning ? html`<button data-testid="basin-cancel" @click=${() => this.model.cancelFill()}>${icons.stop} Cancel</button>` : html`<button data-testid="basin-fill" ?disabled=${!right} @click=${() => this.model.fill(this.#method, this.#axes, this.#cells)}>${icons.play} Fill the map</button>`}
        ${basin ? html`<progress data-testid="basin-progress" data-state=${basin.state} max="1" .value=${basin.progress} aria-label="Part of the map that is filled"></progress><span class="num">${Math.floor(100 * basin.progress)} %</span>` : html`<p>${right ? "Every cell is a start about the right pose." : "First a method has to find a pose, or somebody has to know it."}</p>`}
      </div>
      ${basin ? html`<div><slam-csv .name=${"basin"} .columns=${() => columnsOf(basin)}></slam-csv></div>` : nothing}
      <p aria-live="polite" data-testid="basin-words">${basin && !isRunning ? this.#words(basin) : nothing}</p>`;
  }

  override updated(): void {
    const canvas = this.renderRoot.querySelector("canvas");
    const context = canvas?.getContext("2d");
    const { basin, start } = this.model;
    if (!canvas || !context) return;
    const ratio = Math.min(devicePixelRatio, 2);
    [canvas.width, canvas.height] = [Math.max(1, Math.round(canvas.clientWidth * ratio)), Math.max(1, Math.round(canvas.clientHeight * ratio))];
    if (!basin) return;
    const colours = OUTCOMES.map(({ colour }) => colourOf(this, colour));
    const [wide, high] = [canvas.width / basin.cells, canvas.height / basin.cells];
    basin.outcomes.forEach((outcome, index) => {
      const colour = colours[outcome];
      if (!colour) return;
      context.fillStyle = colour;
      context.globalAlpha = outcome === 1 ? 0.45 : 1;
      const [column, row] = [index % basin.cells, Math.floor(index / basin.cells)];
      const [left, top] = [Math.round(column * wide), Math.round(canvas.height - (row + 1) * high)];
      context.fillRect(left, top, Math.round((column + 1) * wide) - left, Math.round(canvas.height - row * high) - top);
    });
    context.globalAlpha = 1;
    // The right pose, and the present start of the moving cloud.
    const [middleX, middleY, arm] = [0.5 * canvas.width, 0.5 * canvas.height, 7 * ratio];
    const [x, y] = this.#toPicture(basin, canvas, start);
    context.strokeStyle = colourOf(this, "ink");
    context.lineWidth = 2 * ratio;
    context.beginPath();
    context.moveTo(middleX - arm, middleY);
    context.lineTo(middleX + arm, middleY);
    context.moveTo(middleX, middleY - arm);
    context.lineTo(middleX, middleY + arm);
    context.moveTo(x + 6 * ratio, y);
    context.arc(x, y, 6 * ratio, 0, 2 * Math.PI);
    context.stroke();
  }

  #toPicture(basin: BasinMap, canvas: HTMLCanvasElement, start: readonly [number, number, number]): [number, number] {
    const [rightX, rightY, rightTurn] = basin.right;
    const across = (start[0] - rightX) / basin.shift;
    const turn = between([0, 0, rightTurn], [0, 0, start[2]])[2];
    const up = basin.axes === "place" ? (start[1] - rightY) / basin.shift : turn / basin.turn;
    const along = (part: number): number => (0.5 + 0.5 * part * (1 - 1 / basin.cells));
    return [along(across) * canvas.width, (1 - along(up)) * canvas.height];
  }

  readonly #begin = (event: MouseEvent): void => {
    const { basin } = this.model;
    const canvas = event.currentTarget as HTMLCanvasElement;
    if (!basin) return;
    const box = canvas.getBoundingClientRect();
    const part = (at: number): number => (2 * at - 1) / (1 - 1 / basin.cells);
    const [across, up] = [part((event.clientX - box.left) / box.width), part(1 - (event.clientY - box.top) / box.height)];
    const [x, y, turn] = basin.right;
    this.model.move(basin.axes === "place" ? [x + across * basin.shift, y + up * basin.shift, turn] : [x + across * basin.shift, y, turn + up * basin.turn]);
  };

  #words(basin: BasinMap | null): string {
    if (!basin) return "Map of starts: still empty";
    const known = basin.outcomes.filter((outcome) => !Number.isNaN(outcome));
    const part = (outcome: number): string => `${fixed((100 * known.filter((each) => each === outcome).length) / Math.max(known.length, 1), 0)} %`;
    const cut = basin.state === "cancelled" ? t`Cancelled after ${known.length} of ${basin.outcomes.length} starts. ` : "";
    return t`${cut}${wordsOf(basin.method).title}: found from ${part(0)} of ${known.length} starts, wrongly sure in ${part(2)}.`;
  }
}

/** A row for each start: its distance from the right pose, and the outcome. */
function columnsOf({ axes, cells, shift, turn, outcomes, errors }: BasinMap): Column[] {
  const part = (at: number): number => (cells > 1 ? (2 * at) / (cells - 1) - 1 : 0);
  const starts = Array.from(outcomes, (_, i) => ({ across: part(i % cells), up: part(Math.floor(i / cells)) }));
  const isPlace = axes === "place";
  return [
    { title: isPlace ? "x off" : "Shift", unit: "m", values: starts.map(({ across }) => across * shift) },
    { title: isPlace ? "y off" : "Turn", unit: isPlace ? "m" : "°", values: starts.map(({ up }) => (isPlace ? up * shift : (180 / Math.PI) * up * turn)) },
    { title: "Outcome", unit: "", values: Array.from(outcomes, (outcome) => OUTCOMES[outcome]?.words ?? "") },
    { title: "Error", unit: "m", values: errors },
  ];
}

customElements.define("lab-basin", LabBasin);
