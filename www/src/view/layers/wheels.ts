// What the wheels alone would have drawn, over what is really known.

import * as grid from "./grid.js";
import type { Brush } from "./layer.js";

export function draw({ context, camera, scene, palette }: Brush): void {
  const { wheels } = scene;
  wheels.colour(palette, "wheels");
  context.globalAlpha = 0.75;
  grid.draw({ context, camera, tiles: wheels });
}
