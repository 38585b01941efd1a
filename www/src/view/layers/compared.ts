// The trajectories that other methods found on the same log.

import { TRAIL, TRAIL_STRIDE } from "../../protocol/module.js";
import type { PaletteName } from "../palette.js";
import { type Brush, type Pen, stroke } from "./layer.js";

/** Pens of the methods' trajectories, in the order in which the methods are offered. */
const PENS: readonly ({ readonly colour: PaletteName; readonly dash: readonly number[] })[] = [
  { colour: "contest4", dash: [2, 3] },
  { colour: "contest2", dash: [9, 4] },
  { colour: "contest3", dash: [12, 3, 2, 3] },
  { colour: "contest1", dash: [5, 3] },
  { colour: "contest5", dash: [7, 3, 1, 3, 1, 3] },
];

export function methodPen(place: number): Pen & (typeof PENS)[number] {
  const pen = PENS[place % PENS.length] ?? { colour: "ink", dash: [] };
  return { ...pen, width: 2.2 };
}

export function draw(brush: Brush): void {
  const { context, camera, palette } = brush;
  const pixel = camera.px(1.5);
  context.lineJoin = "round";
  for (const { place, trail } of brush.compared) {
    const pen = methodPen(place);
    let [lastX, lastY] = [Infinity, Infinity];
    stroke(brush, { ...pen, colour: palette.css[pen.colour] }, () => {
      for (let i = 0; i + TRAIL_STRIDE <= trail.length; i += TRAIL_STRIDE) {
        const [x, y] = [trail[i + TRAIL.x] ?? NaN, trail[i + TRAIL.y] ?? NaN];
        if (Math.abs(x - lastX) + Math.abs(y - lastY) < pixel) continue;
        context.lineTo(x, y);
        [lastX, lastY] = [x, y];
      }
    });
  }
}
