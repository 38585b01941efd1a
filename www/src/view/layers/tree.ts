// The search tree of the planner.

import { addSegments, type Brush } from "./layer.js";

export function draw({ context, camera, palette, scene }: Brush): void {
  context.strokeStyle = palette.css.tree;
  context.lineWidth = camera.px(1);
  context.globalAlpha = 0.6;
  context.beginPath();
  addSegments(context, scene.tree);
  context.stroke();
  context.globalAlpha = 1;
}
