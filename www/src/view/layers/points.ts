// Points found in the last scan, each with its 95 % ellipse: squares are corners, triangles spikes,
// crosses crossings of lines, rings circles at their true size.

import { POINT, POINT_STRIDE, type PointName } from "../../protocol/module.js";
import type { PathPencil } from "../painter.js";
import { type Brush, stroke } from "./layer.js";
import { ellipseOf } from "./robot.js";

/** In the order of the module. */
const KINDS = ["corner", "spike", "crossing", "circle"] as const satisfies readonly PointName[];

export function draw(brush: Brush): void {
  const { context, camera, palette, scene: { points } } = brush;
  const half = camera.px(5);
  for (let i = 0; i + POINT_STRIDE <= points.length; i += POINT_STRIDE) {
    const at = (place: number): number => points[i + place] ?? NaN;
    const [x, y] = [at(POINT.x), at(POINT.y)];
    const { major, minor, angle } = ellipseOf(at(POINT.varX), at(POINT.covXy), at(POINT.varY));
    stroke(brush, { colour: palette.css.points, width: 1, alpha: 0.8 }, () => context.ellipse(x, y, major, minor, angle, 0, 2 * Math.PI));
    const add = (): void => addSign(context, KINDS[at(POINT.kind)] ?? "corner", x, y, half, at(POINT.radius));
    stroke(brush, { colour: palette.css.free, width: 4, alpha: 0.9 }, add);
    // The less certain, the fainter.
    stroke(brush, { colour: palette.css.points, width: 2, alpha: 0.35 + 0.65 * at(POINT.confidence) }, add);
  }
}

function addSign(context: PathPencil, kind: PointName, x: number, y: number, half: number, radius: number): void {
  switch (kind) {
    case "corner":
      return context.rect(x - half, y - half, 2 * half, 2 * half);
    case "spike":
      context.moveTo(x - half, y - half);
      context.lineTo(x + half, y - half);
      context.lineTo(x, y + half);
      return context.closePath();
    case "crossing":
      context.moveTo(x - half, y - half);
      context.lineTo(x + half, y + half);
      context.moveTo(x - half, y + half);
      return context.lineTo(x + half, y - half);
    case "circle":
      context.moveTo(x + radius, y);
      return context.arc(x, y, radius, 0, 2 * Math.PI);
  }
}
