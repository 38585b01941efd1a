// The contents of a sheet, to be drawn as often as requested: shapes as rows of numbers, and the
// orders in which they and the bulk are drawn.
//
// A shape is a row of eleven words:
//
// | words | segment | ellipse | triangle | text |
// |---|---|---|---|---|
// | 0 to 3 | ends | middle, first half axis | two corners | left, top, width, height |
// | 4 to 7 | half width, dash begun, dash, rounded ends | second half axis, half width (-1: filled), dash | third corner | the same in the atlas |
// | 8, 9 | kind, number of its stroke | | | |
// | 10 | colour | | | |

import type { Tiles } from "../tiles.js";
import { type Matrix } from "./matrix.js";

export const KIND = { segment: 0, ellipse: 1, triangle: 2, text: 3 } as const;
export const ROW = 11;
/** Bytes. */
export const ROW_BYTES = 4 * ROW;

export type Order =
  /** Rows of shapes. */
  | { readonly what: "shapes"; readonly from: number; to: number }
  /** Triangles whose odd (or non-zero) overlaps are visible, then a row that covers them. */
  | { readonly what: "fill"; readonly from: number; readonly to: number; readonly rule: CanvasFillRule }
  | { readonly what: "tiles"; readonly tiles: Tiles; readonly matrix: Matrix; readonly alpha: number }
  | { readonly what: "squares"; readonly points: Float32Array; readonly matrix: Matrix; readonly side: number; readonly colour: number; readonly stroke: number }
  | { readonly what: "segments"; readonly ends: Float32Array; readonly matrix: Matrix; readonly halfWidth: number; readonly dash: number; readonly colour: number; readonly stroke: number };

/** Most stroke numbers in a sheet: as many as the depth buffer can distinguish. */
export const MOST_STROKES = 60_000;

export class List {
  #floats = new Float32Array(ROW * 1024);
  #words = new Uint32Array(this.#floats.buffer);
  count = 0;
  /** Number of the stroke that is being drawn. */
  stroke = 0;
  readonly orders: Order[] = [];
  /** Grows with each recording. */
  version = 0;

  clear(): void {
    [this.count, this.stroke] = [0, 0];
    this.orders.length = 0;
    this.version += 1;
  }

  get rows(): Float32Array {
    return this.#floats.subarray(0, this.count * ROW);
  }

  /** The number of a new stroke. */
  nextStroke(): number {
    this.stroke = Math.min(this.stroke + 1, MOST_STROKES);
    return this.stroke;
  }

  /** Adds a shape, and returns its row. */
  add(kind: number, colour: number, a: number, b: number, c: number, d: number, e: number, f: number, g: number, h: number): number {
    const row = this.addRow(kind, colour, a, b, c, d, e, f, g, h);
    const last = this.orders.at(-1);
    if (last?.what === "shapes" && last.to === row) last.to = row + 1;
    else this.orders.push({ what: "shapes", from: row, to: row + 1 });
    return row;
  }

  /** Adds a row that no order draws yet. */
  addRow(kind: number, colour: number, a: number, b: number, c: number, d: number, e: number, f: number, g: number, h: number): number {
    const row = this.count;
    const at = row * ROW;
    if (at + ROW > this.#floats.length) {
      const grown = new Float32Array(2 * this.#floats.length);
      grown.set(this.#floats);
      [this.#floats, this.#words] = [grown, new Uint32Array(grown.buffer)];
    }
    const floats = this.#floats;
    floats[at] = a;
    floats[at + 1] = b;
    floats[at + 2] = c;
    floats[at + 3] = d;
    floats[at + 4] = e;
    floats[at + 5] = f;
    floats[at + 6] = g;
    floats[at + 7] = h;
    floats[at + 8] = kind;
    floats[at + 9] = this.stroke;
    this.#words[at + 10] = colour;
    this.count = row + 1;
    return row;
  }
}
