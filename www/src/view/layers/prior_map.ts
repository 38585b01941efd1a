// Walls of the map that the robot is to be found in.

import type { Brush } from "./layer.js";

export function draw({ context, camera, palette, scene }: Brush): void {
  const { priorMap } = scene;
  context.beginPath();
  for (let i = 0; i + 3 < priorMap.length; i += 4) {
    context.moveTo(priorMap[i] ?? NaN, priorMap[i + 1] ?? NaN);
    context.lineTo(priorMap[i + 2] ?? NaN, priorMap[i + 3] ?? NaN);
  }
  context.lineWidth = camera.px(1.8);
  context.strokeStyle = palette.css.prior;
  context.stroke();
}
