// What the last scan hit, and the fan in which it looked.

import type { Brush } from "./layer.js";

export function draw({ context, camera, palette, scene }: Brush): void {
  const { scan, status } = scene;
  if (!status || scan.length === 0) return;
  context.fillStyle = context.strokeStyle = palette.css.scan;
  context.globalAlpha = 0.1;
  context.lineWidth = camera.px(1);
  const every = Math.max(1, Math.ceil(scan.length / 2 / 90));
  context.beginPath();
  for (let i = 0; i + 1 < scan.length; i += 2 * every) {
    context.moveTo(status.x, status.y);
    context.lineTo(scan[i] ?? 0, scan[i + 1] ?? 0);
  }
  context.stroke();
  context.globalAlpha = 1;
  const size = Math.max(camera.px(2.5), 0.02);
  context.beginPath();
  for (let i = 0; i + 1 < scan.length; i += 2) context.rect((scan[i] ?? 0) - size / 2, (scan[i + 1] ?? 0) - size / 2, size, size);
  context.fill();
}
