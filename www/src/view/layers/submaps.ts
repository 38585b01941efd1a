// Submaps: the walls of each in a tint of its own, and its number where it begins.

import type { PaletteName } from "../palette.js";
import { type Brush, label } from "./layer.js";
import { writeName } from "./name.js";

/** Neighbours differ; where one passes the other the numbers tell. */
const TINTS = ["contest3", "contest1", "contest5", "contest2", "contest0", "contest7"] as const satisfies readonly PaletteName[];
/** Side of a piece of wall that is seen from near, m. */
const LEAST_SIZE = 0.04;
/** Pixels between the places of two numbers that do not cover each other, across and up. */
const LEAST_APART = [34, 21] as const;

/** The numbers, over what joins the submaps; of two that would cover each other the newer. */
export function drawNumbers(brush: Brush): void {
  const { camera, palette, scene: { submaps } } = brush;
  const written: [number, number][] = [];
  for (let i = submaps.count - 1; i >= 0; i -= 1) {
    const [x, y] = submaps.shown(i);
    const at = camera.toScreen(x, y);
    if (written.some(([a, b]) => Math.abs(a - at[0]) < LEAST_APART[0] && Math.abs(b - at[1]) < LEAST_APART[1])) continue;
    written.push(at);
    label(brush, x, y, () => writeName(brush, String(i), palette.css[tint(i)]));
  }
}

/** The walls alone: where they go while the grid still shows them where they were. */
export function drawWalls({ context, camera, palette, scene: { submaps } }: Brush): void {
  context.globalAlpha = 0.9;
  context.lineWidth = Math.max(camera.px(2.4), LEAST_SIZE);
  context.lineCap = "square";
  submaps.surfaces.forEach((points, i) => {
    const [x, y, heading] = submaps.shown(i);
    context.save();
    context.translate(x, y);
    context.rotate(heading);
    context.strokeStyle = palette.css[tint(i)];
    context.stroke(pathOf(points));
    context.restore();
  });
}

/** Built once, in the frame of the submap: they are drawn at every frame. */
const paths = new WeakMap<Float32Array, Path2D>();

function pathOf(points: Float32Array): Path2D {
  const known = paths.get(points);
  if (known) return known;
  const path = new Path2D();
  for (let i = 0; i + 1 < points.length; i += 2) {
    const [x, y] = [points[i] ?? 0, points[i + 1] ?? 0];
    path.moveTo(x, y);
    // A line without length is none.
    path.lineTo(x + 1e-3, y);
  }
  paths.set(points, path);
  return path;
}

function tint(submap: number): PaletteName {
  return TINTS[submap % TINTS.length] ?? "ink";
}
