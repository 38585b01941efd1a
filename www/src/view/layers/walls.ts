// Segments of the line map: the walls in the filter's state.

import { LINE, LINE_STRIDE } from "../../protocol/module.js";
import { addSegments, type Brush, stroke } from "./layer.js";

export function draw(brush: Brush): void {
  const { context, palette, scene: { lines } } = brush;
  context.lineCap = "round";
  stroke(brush, { colour: palette.css.walls, width: 2.5 }, () => {
    for (let i = 0; i + LINE_STRIDE <= lines.length; i += LINE_STRIDE) {
      if (lines[i + LINE.confirmed]) addSegments(context, lines.subarray(i + LINE.x1, i + LINE.y2 + 1));
    }
  });
}
