// Frontiers: known free cells that touch the unknown. This is where an explorer may go next.

import type { Brush } from "./layer.js";
import { drawSquares } from "./squares.js";

export function draw(brush: Brush): void {
  const { camera, palette, scene: { frontiers, tiles } } = brush;
  drawSquares(brush, frontiers, palette.css.frontiers, Math.max(tiles.resolution, camera.px(2.5)));
}
