// The path: as the search found it (dotted), and after shortening (solid), with the goal.

import { drawGhosts } from "./body.js";
import { addPolyline, type Brush } from "./layer.js";

export function draw(brush: Brush): void {
  const { context, camera, palette, scene, time } = brush;
  const { path, status } = scene;
  context.strokeStyle = palette.css.path;
  context.lineJoin = context.lineCap = "round";
  context.lineWidth = camera.px(3);
  context.beginPath();
  addPolyline(context, path);
  context.stroke();
  drawGhosts(brush, path, palette.css.path);
  if (status && Number.isFinite(status.goalX)) {
    const ring = camera.px(7 + 1.5 * Math.sin(time * 3));
    context.lineWidth = camera.px(2);
    context.beginPath();
    context.arc(status.goalX, status.goalY, ring, 0, 2 * Math.PI);
    context.stroke();
    context.fillStyle = palette.css.path;
    context.beginPath();
    context.arc(status.goalX, status.goalY, camera.px(2.5), 0, 2 * Math.PI);
    context.fill();
  }
}

export function drawRaw({ context, camera, palette, scene }: Brush): void {
  context.strokeStyle = palette.css.path;
  context.lineWidth = camera.px(1.5);
  context.globalAlpha = 0.75;
  context.setLineDash([camera.px(1.5), camera.px(4)]);
  context.beginPath();
  addPolyline(context, scene.rawPath);
  context.stroke();
  context.setLineDash([]);
  context.globalAlpha = 1;
}
