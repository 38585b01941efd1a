// The simulated twin: where a robot with the parameters of the settings would be after the same
// wheel motion.

import { TWIN, TWIN_STRIDE } from "../../protocol/module.js";
import { type Brush, stroke } from "./layer.js";
import { outline } from "./robot.js";

const DASH = [7, 2, 1.5, 2];

export function draw(brush: Brush): void {
  const { context, palette, scene: { twin } } = brush;
  if (twin.length < TWIN_STRIDE) return;
  const colour = palette.css.twin;
  context.lineJoin = "round";
  stroke(brush, { colour, width: 2, dash: DASH }, () => {
    for (let i = 0; i < twin.length; i += TWIN_STRIDE) context.lineTo(twin[i + TWIN.x] ?? NaN, twin[i + TWIN.y] ?? NaN);
  });
  const last = twin.slice(-TWIN_STRIDE);
  outline(brush, last[TWIN.x] ?? NaN, last[TWIN.y] ?? NaN, last[TWIN.heading] ?? NaN, colour, DASH);
}
