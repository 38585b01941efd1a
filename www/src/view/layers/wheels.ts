// The map drawn by odometry alone, over the estimated map.

import type { Brush } from "./layer.js";

/** Least thickness of walls of one cell, CSS pixels: they are the subject of the tour, on a phone
    too, where a cell is a fraction of a pixel. */
const THINNEST = 1.6;

export function draw({ context, bulk, camera, scene, palette }: Brush): void {
  const { wheels } = scene;
  wheels.colour(palette, "wheels");
  context.globalAlpha = 0.75;
  const lacking = camera.px(THINNEST) - wheels.resolution;
  if (lacking <= 0) return bulk.tiles(wheels);
  // Half of the missing width on each side.
  for (const [x, y] of [[-1, -1], [1, -1], [-1, 1], [1, 1]] as const) {
    context.save();
    context.translate((x * lacking) / 2, (y * lacking) / 2);
    bulk.tiles(wheels);
    context.restore();
  }
}
