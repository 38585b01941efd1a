// What the wheels alone would have drawn, over what is really known.

import type { Brush } from "./layer.js";

export function draw({ context, bulk, scene, palette }: Brush): void {
  const { wheels } = scene;
  wheels.colour(palette, "wheels");
  context.globalAlpha = 0.75;
  bulk.tiles(wheels);
}
