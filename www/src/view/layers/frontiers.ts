// Frontiers: known free cells that touch the unknown. This is where an explorer may go next.

import type { Brush } from "./layer.js";

export function draw({ context, camera, palette, scene }: Brush): void {
  const { frontiers, tiles } = scene;
  const size = Math.max(tiles.resolution, camera.px(2.5));
  context.fillStyle = palette.css.frontiers;
  context.beginPath();
  for (let i = 0; i + 1 < frontiers.length; i += 2) {
    context.rect((frontiers[i] ?? 0) - size / 2, (frontiers[i + 1] ?? 0) - size / 2, size, size);
  }
  context.fill();
}
