// Submaps: the walls of each in a tint of its own, with its number where it begins.

import type { PaletteName } from "../palette.js";
import { type Brush, label } from "./layer.js";
import { writeName } from "./name.js";

/** Consecutive submaps differ in tint; where others overlap, the numbers distinguish them. */
const TINTS = ["contest3", "contest1", "contest5", "contest2", "contest0", "contest7"] as const satisfies readonly PaletteName[];
/** Least side of a piece of wall in a close view, m. */
const LEAST_SIZE = 0.04;
/** Width of a piece of wall, CSS pixels, and of one of the chosen submap. */
const WIDTH = 2.4;
const CHOSEN_WIDTH = 5;
/** Pixels between two numbers that do not overlap, across and up. */
const LEAST_APART = [34, 21] as const;

/** The numbers, over the joins of the submaps; of two that would overlap, only the newer. */
export function drawNumbers(brush: Brush): void {
  const { camera, palette, hiddenSubmaps, scene: { submaps } } = brush;
  const written: [number, number][] = [];
  for (let i = submaps.count - 1; i >= 0; i -= 1) {
    if (hiddenSubmaps.has(i)) continue;
    const [x, y] = submaps.shown(i);
    const at = camera.toScreen(x, y);
    if (written.some(([a, b]) => Math.abs(a - at[0]) < LEAST_APART[0] && Math.abs(b - at[1]) < LEAST_APART[1])) continue;
    written.push(at);
    label(brush, x, y, () => writeName(brush, String(i), palette.css[tint(i)]));
  }
}

/** The walls of all submaps: their new places, while the grid still shows the old ones. */
export function drawAll(brush: Brush): void {
  draw(brush, new Set());
}

/** The walls of those that are not hidden; the chosen one stands out. */
export function drawWalls(brush: Brush): void {
  draw(brush, brush.hiddenSubmaps);
}

function draw(brush: Brush, hidden: ReadonlySet<number>): void {
  const { palette, chosenSubmap, scene: { submaps } } = brush;
  submaps.surfaces.forEach((points, i) => {
    if (!hidden.has(i)) drawPoints(brush, points, submaps.shown(i), palette.css[tint(i)], i === chosenSubmap ? CHOSEN_WIDTH : WIDTH);
  });
}

/** Pieces of wall in a frame at pose `place`; `width` in CSS pixels. */
export function drawPoints({ bulk, camera }: Brush, points: Float32Array, place: readonly [number, number, number], colour: string, width: number): void {
  bulk.squares(points, Math.max(camera.px(width), LEAST_SIZE), { colour, alpha: 0.9 }, place);
}

export function tint(submap: number): PaletteName {
  return TINTS[submap % TINTS.length] ?? "ink";
}
