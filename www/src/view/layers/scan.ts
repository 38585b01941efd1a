// The hits of the last scan, and its field of view; for a sonar the cones, because it does not
// measure the direction any better.

import type { Pencil } from "../painter.js";
import { type Brush, stroke } from "./layer.js";

export function draw(brush: Brush): void {
  const { context, bulk, camera, palette, scene: { scan, status } } = brush;
  if (!status || scan.length === 0) return;
  context.fillStyle = context.strokeStyle = palette.css.scan;
  if (status.beamHalfAngle > 0) {
    drawCones(context, scan, status.x, status.y, status.beamHalfAngle, camera.px(1.5));
    return;
  }
  const every = Math.max(1, Math.ceil(scan.length / 2 / 90));
  stroke(brush, { colour: palette.css.scan, width: 1, alpha: 0.1 }, () => {
    for (let i = 0; i + 1 < scan.length; i += 2 * every) {
      context.moveTo(status.x, status.y);
      context.lineTo(scan[i] ?? 0, scan[i + 1] ?? 0);
    }
  });
  context.globalAlpha = 1;
  bulk.squares(scan, Math.max(camera.px(2.5), 0.02), { colour: palette.css.scan });
}

/** The echo came from somewhere on each arc. */
function drawCones(context: Pencil, scan: Float32Array, x: number, y: number, half: number, pixel: number): void {
  context.lineWidth = pixel;
  for (let i = 0; i + 1 < scan.length; i += 2) {
    const [dx, dy] = [(scan[i] ?? 0) - x, (scan[i + 1] ?? 0) - y];
    const [range, axis] = [Math.hypot(dx, dy), Math.atan2(dy, dx)];
    context.globalAlpha = 0.07;
    context.beginPath();
    context.moveTo(x, y);
    context.arc(x, y, range, axis - half, axis + half);
    context.fill();
    context.globalAlpha = 0.9;
    context.beginPath();
    context.arc(x, y, range, axis - half, axis + half);
    context.stroke();
  }
}
