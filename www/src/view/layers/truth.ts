// The true walls and whatever moves: known in the simulation only, dashed because the robot never sees this.

import { addSegments, type Brush } from "./layer.js";

export function draw({ context, camera, palette, scene }: Brush): void {
  context.strokeStyle = palette.css.truth;
  context.lineWidth = camera.px(1.5);
  context.setLineDash([camera.px(5), camera.px(3)]);
  context.beginPath();
  addSegments(context, scene.truth);
  context.stroke();
  context.setLineDash([]);
}
