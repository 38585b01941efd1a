// The search tree of the planner.

import { addSegments, type Brush, stroke } from "./layer.js";

export function draw(brush: Brush): void {
  const { context, palette, scene } = brush;
  stroke(brush, { colour: palette.css.tree, width: 1, alpha: 0.6 }, () => addSegments(context, scene.tree));
}
