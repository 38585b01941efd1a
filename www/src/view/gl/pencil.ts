// A 2D context that draws nothing: it writes into a list what has to be drawn, in device pixels.
// Circles, ellipses, dashes and texts stay such.
//
// | shape | becomes |
// |---|---|
// | line | segments with round ends where they meet |
// | whole circle or ellipse | one row |
// | arc | segments |
// | rectangle, filled | one segment as wide as it |
// | polygon, all of it visible from its first corner | triangles |
// | other polygons, holes | triangles that count how often they cover a pixel (stencil) |
//
// Shapes outside the canvas are left out.

import type { Camera } from "../camera.js";
import type { Pen } from "../layers/layer.js";
import { type Bulk, type Crowd, type Pencil, wholeSide } from "../painter.js";
import type { Tiles } from "../tiles.js";
import type { Atlas } from "./atlas.js";
import { wordOf } from "./colours.js";
import type { Dashes } from "./dashes.js";
import { KIND, type List } from "./list.js";
import { IDENTITY, type Matrix, scaleOf, times } from "./matrix.js";

/** How far outside the canvas shapes are still drawn, device pixels: a sheet may be moved before it
    is recorded again. */
const BESIDE = 300;
/** Largest distance of a polygon from the arc that it approximates, device pixels. */
const SAG = 0.1;
/** Least length of a half axis, device pixels. */
const LEAST_AXIS = 0.4;

class State {
  matrix: Matrix = IDENTITY;
  globalAlpha = 1;
  fillStyle = "#000";
  strokeStyle = "#000";
  lineWidth = 1;
  lineCap: CanvasLineCap = "butt";
  lineJoin: CanvasLineJoin = "miter";
  miterLimit = 10;
  font = "10px sans-serif";
  textAlign: CanvasTextAlign = "start";
  dash: readonly number[] = [];
}

/** A subpath: its corners are in `#x`, `#y`, starting at `from`. */
interface Way { readonly from: number; isClosed: boolean; readonly isRectangle: boolean }
interface Oval { readonly x: number; readonly y: number; readonly u: readonly [number, number]; readonly v: readonly [number, number] }

export class GlPencil extends State implements Pencil, Bulk {
  #kept: State[] = [];
  #x: number[] = [];
  #y: number[] = [];
  #ways: Way[] = [];
  #ovals: Oval[] = [];

  constructor(readonly list: List, readonly camera: Camera, readonly atlas: Atlas, readonly dashes: Dashes) {
    super();
  }

  save(): void {
    const { matrix, globalAlpha, fillStyle, strokeStyle, lineWidth, lineCap, lineJoin, miterLimit, font, textAlign, dash } = this;
    this.#kept.push({ matrix, globalAlpha, fillStyle, strokeStyle, lineWidth, lineCap, lineJoin, miterLimit, font, textAlign, dash });
  }

  restore(): void {
    Object.assign(this, this.#kept.pop());
  }

  setTransform(...matrix: [number, number, number, number, number, number]): void {
    this.matrix = matrix;
  }

  resetTransform(): void {
    this.matrix = IDENTITY;
  }

  transform(...matrix: [number, number, number, number, number, number]): void {
    this.matrix = times(this.matrix, matrix);
  }

  translate(x: number, y: number): void {
    this.transform(1, 0, 0, 1, x, y);
  }

  rotate(angle: number): void {
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    this.transform(cos, sin, -sin, cos, 0, 0);
  }

  getTransform(): DOMMatrix {
    return new DOMMatrix([...this.matrix]);
  }

  setLineDash(lengths: readonly number[]): void {
    this.dash = lengths;
  }

  measureText(text: string): TextMetrics {
    return this.atlas.measure(this.font, text) ?? new TextMetrics();
  }

  // --- Paths ------------------------------------------------------------------------------------

  beginPath(): void {
    this.#x.length = this.#y.length = this.#ways.length = this.#ovals.length = 0;
  }

  moveTo(x: number, y: number): void {
    this.#begin(false);
    this.#corner(x, y);
  }

  lineTo(x: number, y: number): void {
    const last = this.#ways.at(-1);
    if (!last) this.#begin(false);
    else if (last.isClosed) {
      const [startX, startY] = [this.#x[last.from] ?? 0, this.#y[last.from] ?? 0];
      this.#begin(false);
      this.#x.push(startX);
      this.#y.push(startY);
    }
    this.#corner(x, y);
  }

  closePath(): void {
    const last = this.#ways.at(-1);
    if (last) last.isClosed = true;
  }

  rect(x: number, y: number, width: number, height: number): void {
    this.#begin(true);
    this.#corner(x, y);
    this.#corner(x + width, y);
    this.#corner(x + width, y + height);
    this.#corner(x, y + height);
    this.closePath();
  }

  roundRect(x: number, y: number, width: number, height: number, radius: number): void {
    const [right, bottom, quarter] = [x + width - radius, y + height - radius, Math.PI / 2];
    this.#begin(false);
    this.#bend(right, y + radius, radius, radius, 0, -quarter, 0);
    this.#bend(right, bottom, radius, radius, 0, 0, quarter);
    this.#bend(x + radius, bottom, radius, radius, 0, quarter, 2 * quarter);
    this.#bend(x + radius, y + radius, radius, radius, 0, 2 * quarter, 3 * quarter);
    this.closePath();
  }

  arc(x: number, y: number, radius: number, from: number, to: number, isBack = false): void {
    this.ellipse(x, y, radius, radius, 0, from, to, isBack);
  }

  ellipse(x: number, y: number, radiusX: number, radiusY: number, turn: number, from: number, to: number, isBack = false): void {
    if (Math.abs(to - from) >= 2 * Math.PI - 1e-9) {
      const [a, b, c, d, e, f] = this.matrix;
      const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
      const axis = (ux: number, uy: number): [number, number] => [a * ux + c * uy, b * ux + d * uy];
      this.#ovals.push({ x: a * x + c * y + e, y: b * x + d * y + f, u: axis(cos * radiusX, sin * radiusX), v: axis(-sin * radiusY, cos * radiusY) });
      return;
    }
    if (this.#ways.length === 0 || this.#ways.at(-1)?.isClosed) this.#begin(false);
    this.#bend(x, y, radiusX, radiusY, turn, from, isBack ? from - arcLength(to, from) : from + arcLength(from, to));
  }

  #begin(isRectangle: boolean): void {
    this.#ways.push({ from: this.#x.length, isClosed: false, isRectangle });
  }

  #corner(x: number, y: number): void {
    const [a, b, c, d, e, f] = this.matrix;
    this.#x.push(a * x + c * y + e);
    this.#y.push(b * x + d * y + f);
  }

  #bend(x: number, y: number, radiusX: number, radiusY: number, turn: number, from: number, to: number): void {
    const radius = scaleOf(this.matrix) * Math.max(radiusX, radiusY);
    const step = 2 * Math.acos(1 - Math.min(SAG / Math.max(radius, SAG), 0.5));
    const count = Math.max(1, Math.ceil(Math.abs(to - from) / step));
    const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
    for (let k = 0; k <= count; k += 1) {
      const angle = from + ((to - from) * k) / count;
      const [u, v] = [radiusX * Math.cos(angle), radiusY * Math.sin(angle)];
      this.#corner(x + cos * u - sin * v, y + sin * u + cos * v);
    }
  }

  // --- Strokes ----------------------------------------------------------------------------------

  stroke(): void {
    const colour = wordOf(this.strokeStyle, this.globalAlpha);
    if (colour >>> 24 === 0) return;
    const scale = scaleOf(this.matrix);
    const half = (this.lineWidth * scale) / 2;
    const dash = this.dashes.numberOf(this.dash, scale);
    this.list.nextStroke();
    for (const oval of this.#ovals) this.#addOval(oval, colour, half, dash);
    const caps = this.lineCap === "round" ? 3 : 0;
    this.#ways.forEach((way, i) => this.#strokeWay(way, this.#ways[i + 1]?.from ?? this.#x.length, colour, half, dash, caps));
  }

  #strokeWay({ from, isClosed }: Way, to: number, colour: number, half: number, dash: number, caps: number): void {
    const [xs, ys, { list, camera }] = [this.#x, this.#y, this];
    const [right, bottom, beside] = [camera.width * camera.ratio + BESIDE, camera.height * camera.ratio + BESIDE, -BESIDE];
    const last = isClosed ? to : to - 1;
    let way = 0;
    for (let i = from; i < last; i += 1) {
      const j = i + 1 < to ? i + 1 : from;
      const [x1 = NaN, y1 = NaN, x2 = NaN, y2 = NaN] = [xs[i], ys[i], xs[j], ys[j]];
      const length = Math.hypot(x2 - x1, y2 - y1);
      // This includes points that are not finite.
      const isBeside = !(length >= 0) || (x1 < beside && x2 < beside) || (y1 < beside && y2 < beside) || (x1 > right && x2 > right) || (y1 > bottom && y2 > bottom);
      if (!isBeside && (length > 0 || caps !== 0)) {
        // Round where another segment follows; otherwise as the caps are.
        const [starts, ends] = [i > from || isClosed, i + 1 < last || isClosed];
        list.add(KIND.segment, colour, x1, y1, x2, y2, half, way, dash, dash >= 0 || caps === 3 ? caps : (starts ? 1 : 0) + (ends ? 2 : 0));
      }
      if (dash >= 0 && length >= 0) way += length;
    }
  }

  #addOval({ x, y, u, v }: Oval, colour: number, half: number, dash: number): void {
    const { camera, list } = this;
    const reach = Math.hypot(u[0], v[0]) + Math.hypot(u[1], v[1]) + Math.max(half, 0) + BESIDE;
    if (!(x > -reach && y > -reach && x < camera.width * camera.ratio + reach && y < camera.height * camera.ratio + reach)) return;
    const [[ux, uy], [vx, vy]] = axes(u, v);
    list.add(KIND.ellipse, colour, x, y, ux, uy, vx, vy, half, dash);
  }

  // --- Areas ------------------------------------------------------------------------------------

  fill(rule: CanvasFillRule = "nonzero"): void {
    const colour = wordOf(this.fillStyle, this.globalAlpha);
    if (colour >>> 24 === 0) return;
    this.list.nextStroke();
    for (const oval of this.#ovals) this.#addOval(oval, colour, -1, -1);
    const ends = this.#ways.map((_, i) => this.#ways[i + 1]?.from ?? this.#x.length);
    const areSimple = rule === "nonzero" || this.#ways.length === 1;
    if (areSimple && this.#ways.every((way, i) => way.isRectangle || this.#isSeenFromFirst(way.from, ends[i] ?? 0))) {
      this.#ways.forEach((way, i) => (way.isRectangle ? this.#fillRectangle(way.from, colour) : this.#fan(way.from, ends[i] ?? 0, colour)));
    } else this.#fillAny(ends, colour, rule);
  }

  fillRect(x: number, y: number, width: number, height: number): void {
    const [a, b, c, d, e, f] = this.matrix;
    this.list.nextStroke();
    this.#addBox(a * x + c * y + e, b * x + d * y + f, a * width, b * width, c * height, d * height, wordOf(this.fillStyle, this.globalAlpha));
  }

  #fillRectangle(from: number, colour: number): void {
    const [xs, ys] = [this.#x, this.#y];
    const [x = NaN, y = NaN, x1 = NaN, y1 = NaN, x3 = NaN, y3 = NaN] = [xs[from], ys[from], xs[from + 1], ys[from + 1], xs[from + 3], ys[from + 3]];
    this.#addBox(x, y, x1 - x, y1 - y, x3 - x, y3 - y, colour);
  }

  /** A box by a corner and two sides: a segment along the middle, as wide as the second side. */
  #addBox(x: number, y: number, ux: number, uy: number, vx: number, vy: number, colour: number): void {
    const { camera } = this;
    const reach = Math.hypot(ux, uy) + Math.hypot(vx, vy) + BESIDE;
    if (!(x > -reach && y > -reach && x < camera.width * camera.ratio + reach && y < camera.height * camera.ratio + reach)) return;
    this.list.add(KIND.segment, colour, x + vx / 2, y + vy / 2, x + ux + vx / 2, y + uy + vy / 2, Math.hypot(vx, vy) / 2, 0, -1, 0);
  }

  /** Whether all triangles from the first corner have the same orientation. */
  #isSeenFromFirst(from: number, to: number): boolean {
    const [xs, ys] = [this.#x, this.#y];
    const [x = 0, y = 0] = [xs[from], ys[from]];
    let [isLeft, isRight] = [false, false];
    let turned = 0;
    for (let i = from + 1; i + 1 < to; i += 1) {
      const [ax, ay, bx, by] = [(xs[i] ?? 0) - x, (ys[i] ?? 0) - y, (xs[i + 1] ?? 0) - x, (ys[i + 1] ?? 0) - y];
      const area = ax * by - ay * bx;
      if (area > 0) isLeft = true;
      if (area < 0) isRight = true;
      turned += Math.abs(Math.atan2(area, ax * bx + ay * by));
    }
    return !(isLeft && isRight) && turned <= 2 * Math.PI + 1e-6;
  }

  #fan(from: number, to: number, colour: number, isCounted = false): void {
    const [xs, ys, { list }] = [this.#x, this.#y, this];
    const [x = 0, y = 0] = [xs[from], ys[from]];
    for (let i = from + 1; i + 1 < to; i += 1) {
      const row = [KIND.triangle, colour, x, y, xs[i] ?? 0, ys[i] ?? 0, xs[i + 1] ?? 0, ys[i + 1] ?? 0, 0, 0] as const;
      if (isCounted) list.addRow(...row);
      else list.add(...row);
    }
  }

  #fillAny(ends: readonly number[], colour: number, rule: CanvasFillRule): void {
    const { list } = this;
    const [minX, maxX, minY, maxY] = [least(this.#x), -least(this.#x, -1), least(this.#y), -least(this.#y, -1)];
    const { width, height, ratio } = this.camera;
    if (!(maxX > -BESIDE && maxY > -BESIDE && minX < width * ratio + BESIDE && minY < height * ratio + BESIDE)) return;
    const from = list.count;
    this.#ways.forEach((way, i) => this.#fan(way.from, ends[i] ?? 0, colour, true));
    // The last row covers all of them.
    list.addRow(KIND.segment, colour, minX - 1, (minY + maxY) / 2, maxX + 1, (minY + maxY) / 2, (maxY - minY) / 2 + 1, 0, -1, 0);
    list.orders.push({ what: "fill", from, to: list.count, rule });
  }

  // --- Text -------------------------------------------------------------------------------------

  fillText(text: string, x: number, y: number): void {
    this.#write(text, x, y, 0, this.fillStyle);
  }

  strokeText(text: string, x: number, y: number): void {
    this.#write(text, x, y, this.lineWidth, this.strokeStyle);
  }

  /** Texts are upright, whatever the transform. */
  #write(text: string, x: number, y: number, line: number, style: string): void {
    const [a, b, c, d, e, f] = this.matrix;
    const scale = scaleOf(this.matrix);
    const glyphs = this.atlas.glyphs(this.font, text, scale, line);
    if (!glyphs) return;
    const width = this.textAlign === "center" || this.textAlign === "right" || this.textAlign === "end" ? scale * (this.atlas.measure(this.font, text)?.width ?? 0) : 0;
    const [atX, atY] = [a * x + c * y + e - (this.textAlign === "center" ? width / 2 : width), b * x + d * y + f];
    this.list.nextStroke();
    this.list.add(KIND.text, wordOf(style, this.globalAlpha), Math.round(atX) - glyphs.left, Math.round(atY) - glyphs.rise, glyphs.width, glyphs.height, glyphs.x, glyphs.y, glyphs.width, glyphs.height);
  }

  // --- Bulk -------------------------------------------------------------------------------------

  tiles(tiles: Tiles): void {
    this.list.orders.push({ what: "tiles", tiles, matrix: this.matrix, alpha: this.globalAlpha });
  }

  squares(points: Float32Array, side: number, { colour, alpha = 1 }: Crowd, [x, y, heading]: readonly [number, number, number] = [0, 0, 0]): void {
    if (points.length === 0) return;
    const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
    const matrix = times(this.matrix, [cos, sin, -sin, cos, x, y]);
        this.list.orders.push({ what: "squares", points, matrix, side: wholeSide(side, scaleOf(this.matrix)), colour: wordOf(colour, alpha), stroke: this.list.nextStroke() });
  }

  segments(ends: Float32Array, { colour, width, alpha = 1, dash = [] }: Pen): void {
    if (ends.length === 0) return;
    const { ratio } = this.camera;
    const order = { what: "segments", ends, matrix: this.matrix, halfWidth: (width * ratio) / 2, dash: this.dashes.numberOf(dash, ratio), colour: wordOf(colour, alpha) } as const;
    this.list.orders.push({ ...order, stroke: this.list.nextStroke() });
  }
}

/** The least of the values times `sign`. */
function least(values: readonly number[], sign = 1): number {
  return values.reduce((found, value) => Math.min(found, sign * value), Infinity);
}

/** The forward length of an arc: less than a full turn. */
function arcLength(from: number, to: number): number {
  const turn = 2 * Math.PI;
  return (((to - from) % turn) + turn) % turn;
}

/** Two perpendicular half axes, neither of them of zero length. */
function axes(u: readonly [number, number], v: readonly [number, number]): [readonly [number, number], readonly [number, number]] {
  const [long, short] = [Math.hypot(...u), Math.hypot(...v)];
  const first = long >= LEAST_AXIS ? u : long > 0 ? [(u[0] / long) * LEAST_AXIS, (u[1] / long) * LEAST_AXIS] as const : [LEAST_AXIS, 0] as const;
  const grown = short >= LEAST_AXIS ? 1 : LEAST_AXIS / Math.max(short, 1e-12);
  if (short > 1e-12) return [first, [v[0] * grown, v[1] * grown]];
  const length = Math.hypot(...first);
  return [first, [(-first[1] / length) * LEAST_AXIS, (first[0] / length) * LEAST_AXIS]];
}
