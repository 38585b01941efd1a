// The lines found in the last scan, before they are matched to walls.

import { addSegments, type Brush, stroke } from "./layer.js";

export function draw(brush: Brush): void {
  const { context, palette, scene } = brush;
  context.lineCap = "round";
  for (const [colour, width] of [[palette.css.free, 7], [palette.css.found, 3.5]] as const) {
    stroke(brush, { colour, width }, () => addSegments(context, scene.found));
  }
}
