// Submaps: the walls of each in a tint of its own, and its number where it begins.

import type { PaletteName } from "../palette.js";
import { type Brush, label } from "./layer.js";
import { writeName } from "./name.js";

/** Neighbours differ; where one passes the other the numbers tell. */
const TINTS = ["contest3", "contest1", "contest5", "contest2", "contest0", "contest7"] as const satisfies readonly PaletteName[];
/** Pixels between two numbers that can still be read. */
const LEAST_APART = 22;

export function draw(brush: Brush): void {
  drawWalls(brush);
  const { camera, palette, scene: { submaps } } = brush;
  const written: [number, number][] = [];
  for (let i = submaps.count - 1; i >= 0; i -= 1) {
    const [x, y] = submaps.shown(i);
    const at = camera.toScreen(x, y);
    if (written.some(([a, b]) => Math.hypot(a - at[0], b - at[1]) < LEAST_APART)) continue;
    written.push(at);
    label(brush, x, y, () => writeName(brush, String(i), palette.css[tint(i)]));
  }
}

/** The walls alone: where they go while the grid still shows them where they were. */
export function drawWalls({ context, camera, palette, scene: { submaps } }: Brush): void {
  const size = camera.px(2.4);
  context.globalAlpha = 0.9;
  submaps.surfaces.forEach((points, i) => {
    const [x, y, heading] = submaps.shown(i);
    const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
    context.fillStyle = palette.css[tint(i)];
    for (let p = 0; p + 1 < points.length; p += 2) {
      const [a, b] = [points[p] ?? 0, points[p + 1] ?? 0];
      context.fillRect(x + cos * a - sin * b - size / 2, y + sin * a + cos * b - size / 2, size, size);
    }
  });
}

function tint(submap: number): PaletteName {
  return TINTS[submap % TINTS.length] ?? "ink";
}
