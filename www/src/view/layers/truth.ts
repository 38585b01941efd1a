// The true walls and whatever moves: known in the simulation only, dashed because the robot never sees this.

import { addSegments, type Brush } from "./layer.js";

/** The walls; they stand still, so they are drawn with the ground. */
export function drawWalls({ context, camera, palette, scene }: Brush): void {
  context.strokeStyle = palette.css.truth;
  context.lineWidth = camera.px(1.5);
  context.setLineDash([camera.px(5), camera.px(3)]);
  context.beginPath();
  addSegments(context, scene.truth);
  context.stroke();
  context.setLineDash([]);
}

export function drawMovers({ context, camera, palette, scene }: Brush): void {
  context.lineWidth = camera.px(1.5);
  context.strokeStyle = context.fillStyle = palette.css.truth;
  context.globalAlpha = 0.35;
  const { movers } = scene;
  for (let i = 0; i + 2 < movers.length; i += 3) {
    context.beginPath();
    context.arc(movers[i] ?? 0, movers[i + 1] ?? 0, movers[i + 2] ?? 0, 0, 2 * Math.PI);
    context.fill();
    context.stroke();
  }
  context.globalAlpha = 1;
}
