// Frontiers: known free cells that touch the unknown. This is where an explorer may go next.

import type { Brush } from "./layer.js";

export function draw({ bulk, camera, palette, scene: { frontiers, tiles } }: Brush): void {
  bulk.squares(frontiers, Math.max(tiles.resolution, camera.px(2.5)), { colour: palette.css.frontiers });
}
