// Submaps: the walls of each in a tint of its own, and its number where it begins.

import type { PaletteName } from "../palette.js";
import { type Brush, label } from "./layer.js";
import { writeName } from "./name.js";

/** Neighbours differ; where one passes the other the numbers tell. */
const TINTS = ["contest3", "contest1", "contest5", "contest2", "contest0", "contest7"] as const satisfies readonly PaletteName[];
/** Side of a piece of wall that is seen from near, m. */
const LEAST_SIZE = 0.04;
/** Width of a piece of wall, CSS pixels, and of one of the submap that was chosen. */
const WIDTH = 2.4;
const CHOSEN_WIDTH = 5;
/** Pixels between the places of two numbers that do not cover each other, across and up. */
const LEAST_APART = [34, 21] as const;

/** The numbers, over what joins the submaps; of two that would cover each other the newer. */
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

/** The walls alone of all: where they go while the grid still shows them where they were. */
export function drawAll(brush: Brush): void {
  draw(brush, new Set());
}

/** The walls of those that are not hidden; the one that was chosen stands out. */
export function drawWalls(brush: Brush): void {
  draw(brush, brush.hiddenSubmaps);
}

function draw(brush: Brush, hidden: ReadonlySet<number>): void {
  const { palette, chosenSubmap, scene: { submaps } } = brush;
  submaps.surfaces.forEach((points, i) => {
    if (!hidden.has(i)) drawPoints(brush, points, submaps.shown(i), palette.css[tint(i)], i === chosenSubmap ? CHOSEN_WIDTH : WIDTH);
  });
}

/** Pieces of wall in a frame that lies at `place`; `width` in CSS pixels. */
export function drawPoints({ bulk, camera }: Brush, points: Float32Array, place: readonly [number, number, number], colour: string, width: number): void {
  bulk.squares(points, Math.max(camera.px(width), LEAST_SIZE), { colour, alpha: 0.9 }, place);
}

export function tint(submap: number): PaletteName {
  return TINTS[submap % TINTS.length] ?? "ink";
}
