// The part of the robot that touches walls: its disc or rectangle, also at the corners of a path.

import type { PathPencil } from "../painter.js";
import { type Brush, stroke } from "./layer.js";

/** Adds the body at a pose to the path of the context, at its true size. */
export function addBody({ context, scene: { status } }: Brush, x: number, y: number, heading: number): void {
  if (!status) return;
  const { halfLength, halfWidth, isRectangle } = status;
  if (!isRectangle) {
    const radius = Math.hypot(halfLength, halfWidth);
    context.moveTo(x + radius, y);
    context.arc(x, y, radius, 0, 2 * Math.PI);
    return;
  }
  addShape(context, x, y, heading, [[halfLength, halfWidth], [-halfLength, halfWidth], [-halfLength, -halfWidth], [halfLength, -halfWidth]]);
}

/** Adds a closed shape at a pose to the path; its corners are given forward and to the left. */
export function addShape(context: PathPencil, x: number, y: number, heading: number, corners: readonly (readonly [number, number])[]): void {
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  corners.forEach(([forward, left], i) => {
    const corner = [x + c * forward - s * left, y + s * forward + c * left] as const;
    if (i === 0) context.moveTo(...corner);
    else context.lineTo(...corner);
  });
  context.closePath();
}

/** The body at the corners of a path, as it arrives and as it leaves; only if it is not a disc. */
export function drawGhosts(brush: Brush, path: Float32Array, colour: string): void {
  if (!brush.scene.status?.isRectangle) return;
  stroke(brush, { colour, width: 1, alpha: 0.7 }, () => {
    for (let i = 0; i + 3 < path.length; i += 2) {
      const [ax = 0, ay = 0, bx = 0, by = 0] = path.subarray(i, i + 4);
      const heading = Math.atan2(by - ay, bx - ax);
      if (i > 0) addBody(brush, ax, ay, heading);
      addBody(brush, bx, by, heading);
    }
  });
}
