// Walls of the map that the robot is to be found in.

import type { Brush } from "./layer.js";

export function draw({ context, camera, palette, scene }: Brush): void {
  const { known } = scene;
  context.beginPath();
  for (let i = 0; i + 3 < known.length; i += 4) {
    context.moveTo(known[i] ?? NaN, known[i + 1] ?? NaN);
    context.lineTo(known[i + 2] ?? NaN, known[i + 3] ?? NaN);
  }
  context.lineWidth = camera.px(1.8);
  context.strokeStyle = palette.css.known;
  context.stroke();
}
