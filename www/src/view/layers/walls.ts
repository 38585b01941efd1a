// Segments of the line map: the walls that the filter believes in.

import { LINE_STRIDE } from "../../protocol.js";
import type { Brush } from "./layer.js";

export function draw({ context, camera, palette, scene }: Brush): void {
  const { lines } = scene;
  context.strokeStyle = palette.css.walls;
  context.lineWidth = camera.px(2.5);
  context.lineCap = "round";
  context.beginPath();
  for (let i = 0; i + LINE_STRIDE <= lines.length; i += LINE_STRIDE) {
    if (!lines[i + 10]) continue;
    context.moveTo(lines[i + 5] ?? 0, lines[i + 6] ?? 0);
    context.lineTo(lines[i + 7] ?? 0, lines[i + 8] ?? 0);
  }
  context.stroke();
}
