// What the wheels alone would have drawn, over what is really known.

import type { Brush } from "./layer.js";

/** Walls of one cell are drawn at least so thick, CSS pixels: they are the story of a first visit,
    on a phone too, where a cell is a fraction of a pixel. */
const THINNEST = 1.6;

export function draw({ context, bulk, camera, scene, palette }: Brush): void {
  const { wheels } = scene;
  wheels.colour(palette, "wheels");
  context.globalAlpha = 0.75;
  const lacking = camera.px(THINNEST) - wheels.resolution;
  if (lacking <= 0) return bulk.tiles(wheels);
  // Half of what is lacking to each side.
  for (const [x, y] of [[-1, -1], [1, -1], [-1, 1], [1, 1]] as const) {
    context.save();
    context.translate((x * lacking) / 2, (y * lacking) / 2);
    bulk.tiles(wheels);
    context.restore();
  }
}
