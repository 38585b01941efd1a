// Loop closures: a line between two submaps for each place that was recognised, or might have been.
// Solid: accepted; thin: consecutive submaps, which close no loop; dotted: waiting; dashed:
// refused; dashed and dotted: revoked.

import { CLOSURE, CLOSURE_STRIDE } from "../../protocol/module.js";
import type { PaletteName } from "../palette.js";
import { type Fate, type Submaps, within } from "../submaps.js";
import { type Brush, disc, nearestSegment, type Pen, stroke } from "./layer.js";

/** How each is drawn; the most important come last, on top. */
export const CLOSURE_PENS: Readonly<Record<Fate, { readonly colour: PaletteName } & Omit<Pen, "colour">>> = {
  neighbour: { colour: "ink", width: 1, alpha: 0.22, dash: [] },
  refused: { colour: "refused", width: 1.4, alpha: 0.65, dash: [7, 5] },
  revoked: { colour: "revoked", width: 1.8, alpha: 0.9, dash: [9, 4, 1.5, 4] },
  waiting: { colour: "waiting", width: 1.8, alpha: 0.9, dash: [1.5, 4] },
  accepted: { colour: "accepted", width: 1.8, alpha: 0.95, dash: [] },
};
/** Up to this many can be told apart. More are drawn with the thinnest lines, a tenth of the work
    of others, and more faintly the more there are, down to a limit. */
const FEW = 80;
const FAINTEST = 0.3;
/** A newly accepted closure stands out, by so many pixels at first. */
const FRESH_WIDTH = 3;

export function draw(brush: Brush): void {
  const { context, camera, palette: { css }, scene: { submaps }, thing } = brush;
  const lines = linesOf(submaps);
  context.lineCap = "round";
  const add = (row: number): void => {
    context.moveTo(lines[4 * row] ?? 0, lines[4 * row + 1] ?? 0);
    context.lineTo(lines[4 * row + 2] ?? 0, lines[4 * row + 3] ?? 0);
  };
  const loops = submaps.fates.filter((fate) => fate === "accepted").length;
  const crowd = Math.max(FAINTEST, Math.min(1, Math.sqrt(FEW / loops)));
  for (const [fate, pen] of Object.entries(CLOSURE_PENS)) {
    const alpha = fate === "accepted" ? crowd : 1;
    const width = alpha < 1 ? 1 / camera.ratio : pen.width;
    stroke(brush, { ...pen, width, alpha: alpha * (pen.alpha ?? 1), colour: css[pen.colour] }, () => submaps.fates.forEach((each, row) => each === fate && add(row)));
  }
  const { rows, part } = submaps.fresh;
  if (part > 0) stroke(brush, { colour: css.accepted, width: 1.8 + FRESH_WIDTH * part, alpha: part }, () => rows.forEach(add));
  const row = thing?.kind === "closure" ? rowOf(submaps, thing.name) : null;
  if (row === null) return;
  const fate = submaps.fates[row];
  if (!fate) return;
  const pen = CLOSURE_PENS[fate];
  stroke(brush, { colour: css.ink, width: 7 }, () => add(row));
  stroke(brush, { colour: css.free, width: 4.5 }, () => add(row));
  stroke(brush, { ...pen, colour: css[pen.colour], width: 3, alpha: 1 }, () => add(row));
  // Where the new submap would lie, if only this placement were believed.
  const at = row * CLOSURE_STRIDE;
  const [x, y] = within(submaps.shown(submaps.closures[at + CLOSURE.old] ?? 0), submaps.closures[at + CLOSURE.x] ?? NaN, submaps.closures[at + CLOSURE.y] ?? NaN);
  const [endX, endY] = [lines[4 * row + 2] ?? NaN, lines[4 * row + 3] ?? NaN];
  stroke(brush, { colour: css.ink, width: 1.6, dash: [2, 3] }, () => {
    context.moveTo(endX, endY);
    context.lineTo(x, y);
  });
  context.fillStyle = css.ink;
  disc(brush, x, y, camera.px(5));
  context.fillStyle = css[pen.colour];
  disc(brush, x, y, camera.px(3.2));
}

/** x1 y1 x2 y2 of each, as drawn now. */
function linesOf(submaps: Submaps): Float32Array {
  const { closures } = submaps;
  const count = closures.length / CLOSURE_STRIDE;
  const lines = new Float32Array(4 * count);
  for (let row = 0; row < count; row += 1) {
    const at = row * CLOSURE_STRIDE;
    const [from, to] = [submaps.shown(closures[at + CLOSURE.old] ?? 0), submaps.shown(closures[at + CLOSURE.new] ?? 0)];
    lines.set([from[0], from[1], to[0], to[1]], 4 * row);
  }
  return lines;
}

/** A closure is named by its two submaps, for as long as it is remembered. */
export type ClosureName = readonly [number, number];

/** Its row; if two submaps were compared more than once, the newest. */
export function rowOf({ closures }: Submaps, [old, next]: ClosureName): number | null {
  for (let at = closures.length - CLOSURE_STRIDE; at >= 0; at -= CLOSURE_STRIDE) {
    if (closures[at + CLOSURE.old] === old && closures[at + CLOSURE.new] === next) return at / CLOSURE_STRIDE;
  }
  return null;
}

/** The closure whose line is nearest to a map point, within `reach`, m. */
export function closureAt(submaps: Submaps, x: number, y: number, reach: number): ClosureName | null {
  const found = nearestSegment(linesOf(submaps), 4, 0, x, y, reach);
  if (found === null) return null;
  const at = (found / 4) * CLOSURE_STRIDE;
  return [submaps.closures[at + CLOSURE.old] ?? NaN, submaps.closures[at + CLOSURE.new] ?? NaN];
}
