// Walls of the prior map.

import { addSegments, type Brush, stroke } from "./layer.js";

export function draw(brush: Brush): void {
  const { context, palette, scene } = brush;
  stroke(brush, { colour: palette.css.prior, width: 1.8 }, () => addSegments(context, scene.priorMap));
}
