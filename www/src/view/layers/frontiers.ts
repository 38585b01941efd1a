// Frontiers: known free cells that touch unknown ones. An explorer may go there next.

import type { Brush } from "./layer.js";

export function draw({ bulk, camera, palette, scene: { frontiers, tiles } }: Brush): void {
  bulk.squares(frontiers, Math.max(tiles.resolution, camera.px(2.5)), { colour: palette.css.frontiers });
}
