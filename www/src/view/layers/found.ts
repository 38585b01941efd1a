// The lines found in the last scan, before anything is known of which walls they are.

import { addSegments, type Brush } from "./layer.js";

export function draw({ context, camera, palette, scene }: Brush): void {
  if (scene.found.length === 0) return;
  context.lineCap = "round";
  for (const [colour, width] of [[palette.css.free, 7], [palette.css.found, 3.5]] as const) {
    context.strokeStyle = colour;
    context.lineWidth = camera.px(width);
    context.beginPath();
    addSegments(context, scene.found);
    context.stroke();
  }
}
