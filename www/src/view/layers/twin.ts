// The simulated twin: where a robot with the figures of the settings would be after the same motion
// of the wheels.

import { TWIN, TWIN_STRIDE } from "../../protocol/module.js";
import type { Brush } from "./layer.js";
import { outline } from "./robot.js";

const DASH = [7, 2, 1.5, 2];

export function draw(brush: Brush): void {
  const { context, camera, palette, scene } = brush;
  const { twin } = scene;
  if (twin.length < TWIN_STRIDE) return;
  context.strokeStyle = palette.css.twin;
  context.lineWidth = camera.px(2);
  context.lineJoin = "round";
  context.setLineDash(DASH.map((length) => camera.px(length)));
  context.beginPath();
  for (let i = 0; i < twin.length; i += TWIN_STRIDE) context.lineTo(twin[i + TWIN.x] ?? NaN, twin[i + TWIN.y] ?? NaN);
  context.stroke();
  context.setLineDash([]);
  const last = twin.length - TWIN_STRIDE;
  outline(brush, twin[last + TWIN.x] ?? NaN, twin[last + TWIN.y] ?? NaN, twin[last + TWIN.heading] ?? NaN, palette.css.twin, DASH);
}
