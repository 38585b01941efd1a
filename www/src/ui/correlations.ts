// The correlation matrix of the filter as an image: it shows which errors are correlated, and is
// linked to the walls on the map.

import { css, type TemplateResult } from "lit";
import { firstRowOf, rowOf, type Row, sizeOf } from "../inspect.js";
import type { Inspection } from "../protocol/module.js";
import { SlamElement } from "./element.js";
import { type Rgb, rgb } from "../view/palette.js";
import { mix, packed } from "../view/tiles.js";
import { html } from "../words.js";
import { fixed } from "./format.js";
import { colourOf } from "./plot_style.js";

const TONES = 128;

export class SlamCorrelations extends SlamElement {
  static override styles = css`
    :host { margin-top: 14px; }
    h2 { margin-bottom: 6px; }
    p { margin: 0 0 8px; font-size: 12.5px; color: var(--muted); }
    #field { position: relative; aspect-ratio: 1; border: 1px solid var(--line); cursor: crosshair; touch-action: pan-y; overflow: hidden; background: var(--corr-zero); }
    canvas { position: absolute; inset: 0; width: 100%; height: 100%; image-rendering: pixelated; }
    .mark { position: absolute; pointer-events: none; border: 1.5px solid var(--ink); display: none; }
    .mark.row { left: -2px; right: -2px; }
    .mark.column { top: -2px; bottom: -2px; }
    .mark.chosen { border-color: var(--map-path); border-width: 2px; }
    #readout { min-height: 40px; margin: 6px 0 8px; font-size: 13px; color: var(--ink); }
    .scale { display: grid; grid-template-columns: auto 1fr auto; gap: 8px; align-items: center; font: 500 11.5px/1 var(--mono); color: var(--muted); }
    .scale i { height: 10px; border-radius: 5px; border: 1px solid var(--line); background: linear-gradient(90deg, var(--corr-minus), var(--corr-zero), var(--corr-plus)); }
  `;

  protected override readonly topics = ["inspection", "spot", "theme", "run"] as const;
  /** The cell under the pointer or under the keyboard's cursor. */
  #cell: readonly [row: number, column: number] | null = null;
  #painted: { inspection: Inspection | null; theme: string } = { inspection: null, theme: "" };
  #tones = new Uint32Array(2 * TONES + 1);

  override render(): TemplateResult {
    const { inspection, method } = this.store;
    this.toggleAttribute("hidden", method !== "line-ekf");
    const n = inspection ? sizeOf(inspection) : 0;
    return html`<h2>What hangs together</h2>
      <p>Correlation of all errors: first the robot's pose and its odometry, then α and r of each wall. Walls seen from one place err together: that is why meeting one of them again mends all.</p>
      <div id="field" tabindex="0" role="application" data-testid="correlations" data-rows=${n}
        aria-label="Correlation matrix. Arrow keys move from cell to cell." aria-describedby="readout"
        @pointermove=${this.#point} @pointerdown=${this.#point} @pointerleave=${this.#leave} @keydown=${this.#key} @click=${this.#pin}>
        <canvas></canvas>
        <div class="mark row chosen" id="chosen-row"></div><div class="mark column chosen" id="chosen-column"></div>
        <div class="mark row" id="row"></div><div class="mark column" id="column"></div>
      </div>
      <div id="readout" data-testid="correlation" aria-live="polite">${this.#words(inspection)}</div>
      <div class="scale" aria-hidden="true"><span>−1</span><i></i><span>+1</span></div>`;
  }

  override updated(): void {
    const { inspection } = this.store;
    const theme = getComputedStyle(this).getPropertyValue("color");
    if (inspection && (inspection !== this.#painted.inspection || theme !== this.#painted.theme)) {
      if (theme !== this.#painted.theme) this.#mixTones();
      this.#painted = { inspection, theme };
      this.#paint(inspection);
    }
    const { spot } = this.store;
    const pinned = inspection && spot.pinned !== null ? firstRowOf(inspection, spot.pinned) : null;
    this.#mark("chosen-row", "chosen-column", pinned, pinned, 2);
    const hovered = inspection && !this.#cell && spot.hovered.length > 0 ? firstRowOf(inspection, spot.hovered[0] ?? -1) : null;
    if (hovered !== null) this.#mark("row", "column", hovered, hovered, 2);
    else this.#mark("row", "column", this.#cell?.[0] ?? null, this.#cell?.[1] ?? null, 1);
  }

  #words(inspection: Inspection | null): TemplateResult | string {
    if (!inspection) return "The matrix comes with the next scan.";
    if (!this.#cell) return html`<span class="muted">Point at a cell: its two walls light up on the map. Click to keep one.</span>`;
    const [row, column] = this.#cell;
    const value = inspection.coefficients[row * sizeOf(inspection) + column] ?? NaN;
    return html`<b class="num">${fixed(value, 2)}</b> between ${nameOf(rowOf(inspection, row))} and ${nameOf(rowOf(inspection, column))}`;
  }

  #paint(inspection: Inspection): void {
    const canvas = this.renderRoot.querySelector("canvas");
    const context = canvas?.getContext("2d");
    const n = sizeOf(inspection);
    if (!canvas || !context || n === 0) return;
    canvas.width = canvas.height = n;
    const image = context.createImageData(n, n);
    const pixels = new Uint32Array(image.data.buffer);
    inspection.coefficients.forEach((value, i) => (pixels[i] = this.#tones[Math.round((Math.min(Math.max(value, -1), 1) + 1) * TONES)] ?? 0));
    context.putImageData(image, 0, 0);
  }

  /** The tones from -1 through 0 to 1, in the colours of the theme. */
  #mixTones(): void {
    const probe = this.renderRoot.querySelector<HTMLElement>("#readout");
    if (!probe) return;
    const colour = (name: string): Rgb => rgb(colourOf(probe, `corr-${name}`));
    const [minus, zero, plus] = [colour("minus"), colour("zero"), colour("plus")];
    this.#tones.forEach((_, i) => {
      const part = (i - TONES) / TONES;
      this.#tones[i] = packed(mix(zero, part < 0 ? minus : plus, Math.abs(part)));
    });
  }

  #mark(rowId: string, columnId: string, row: number | null, column: number | null, size: number): void {
    const { inspection } = this.store;
    const n = inspection ? sizeOf(inspection) : 0;
    const place = (id: string, at: number | null, start: "top" | "left", extent: "height" | "width"): void => {
      const mark = this.renderRoot.querySelector<HTMLElement>(`#${id}`);
      mark?.style.setProperty("display", at === null || n === 0 ? "none" : "block");
      if (at === null || n === 0) return;
      mark?.style.setProperty(start, `calc(${(100 * at) / n}% - 1px)`);
      mark?.style.setProperty(extent, `calc(${(100 * size) / n}% + 2px)`);
    };
    place(rowId, row, "top", "height");
    place(columnId, column, "left", "width");
  }

  #point(event: PointerEvent): void {
    const { inspection } = this.store;
    if (!inspection) return;
    const box = (event.currentTarget as HTMLElement).getBoundingClientRect();
    const n = sizeOf(inspection);
    const at = (part: number): number => Math.min(Math.max(Math.floor(part * n), 0), n - 1);
    this.#choose([at((event.clientY - box.top) / box.height), at((event.clientX - box.left) / box.width)]);
  }

  /** After a touch, the cell that was touched stays selected. */
  #leave(event: PointerEvent): void {
    if (event.pointerType === "mouse") this.#choose(null);
  }

  #key(event: KeyboardEvent): void {
    const { inspection } = this.store;
    const steps: Record<string, readonly [number, number]> = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };
    const step = steps[event.key];
    if (!inspection || (!step && event.key !== "Enter")) return;
    event.preventDefault();
    event.stopPropagation();
    if (!step) return this.#pin();
    const last = sizeOf(inspection) - 1;
    const [row, column] = this.#cell ?? [0, 0];
    this.#choose([Math.min(Math.max(row + step[0], 0), last), Math.min(Math.max(column + step[1], 0), last)]);
  }

  /** Pins the wall of the cell's row, or else of its column. */
  #pin(): void {
    const walls = this.#walls();
    const wall = walls[0] ?? null;
    this.store.point({ pinned: wall === this.store.spot.pinned ? null : wall });
  }

  #choose(cell: readonly [number, number] | null): void {
    this.#cell = cell;
    this.store.point({ hovered: this.#walls() });
  }

  /** The walls of the cell; a cell on the diagonal has one. */
  #walls(): number[] {
    const { inspection } = this.store;
    if (!inspection || !this.#cell) return [];
    const walls = this.#cell.map((index) => rowOf(inspection, index).wall);
    return [...new Set(walls)].filter((wall) => wall !== null);
  }
}

function nameOf({ symbol, owner }: Row): TemplateResult {
  return html`<b>${symbol}</b> of ${owner}`;
}

customElements.define("slam-correlations", SlamCorrelations);
