// Segments of the line map: the walls that the filter believes in.

import { LINE, LINE_STRIDE } from "../../protocol/module.js";
import type { Brush } from "./layer.js";

export function draw({ context, camera, palette, scene }: Brush): void {
  const { lines } = scene;
  context.strokeStyle = palette.css.walls;
  context.lineWidth = camera.px(2.5);
  context.lineCap = "round";
  context.beginPath();
  for (let i = 0; i + LINE_STRIDE <= lines.length; i += LINE_STRIDE) {
    if (!lines[i + LINE.confirmed]) continue;
    context.moveTo(lines[i + LINE.x1] ?? 0, lines[i + LINE.y1] ?? 0);
    context.lineTo(lines[i + LINE.x2] ?? 0, lines[i + LINE.y2] ?? 0);
  }
  context.stroke();
}
