// The path: as the search found it (dotted), and after shortening (solid), with the goal.

import { drawGhosts } from "./body.js";
import { addPolyline, type Brush, disc, stroke } from "./layer.js";

export function draw(brush: Brush): void {
  const { context, camera, palette, scene: { path, status }, time } = brush;
  const colour = palette.css.path;
  context.lineJoin = context.lineCap = "round";
  stroke(brush, { colour, width: 3 }, () => addPolyline(context, path));
  drawGhosts(brush, path, colour);
  if (!status || !Number.isFinite(status.goalX)) return;
  const ring = camera.px(7 + 1.5 * Math.sin(time * 3));
  stroke(brush, { colour, width: 2 }, () => context.arc(status.goalX, status.goalY, ring, 0, 2 * Math.PI));
  context.fillStyle = colour;
  disc(brush, status.goalX, status.goalY, camera.px(2.5));
}

export function drawRaw(brush: Brush): void {
  const { context, palette, scene } = brush;
  stroke(brush, { colour: palette.css.path, width: 1.5, alpha: 0.75, dash: [1.5, 4] }, () => addPolyline(context, scene.rawPath));
}
