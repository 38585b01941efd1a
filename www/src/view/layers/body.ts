// What of the robot touches walls: the disc around it, or its rectangle; and where that stands
// along a path.

import type { Brush } from "./layer.js";

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
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  const to = (forward: number, left: number): [number, number] => [x + c * forward - s * left, y + s * forward + c * left];
  context.moveTo(...to(halfLength, halfWidth));
  context.lineTo(...to(-halfLength, halfWidth));
  context.lineTo(...to(-halfLength, -halfWidth));
  context.lineTo(...to(halfLength, -halfWidth));
  context.closePath();
}

/** The body at the corners of a path, as it comes to them and as it leaves them; only of one that
    is no disc. */
export function drawGhosts(brush: Brush, path: Float32Array, colour: string): void {
  if (!brush.scene.status?.isRectangle) return;
  const { context, camera } = brush;
  context.strokeStyle = colour;
  context.lineWidth = camera.px(1);
  context.globalAlpha = 0.7;
  context.beginPath();
  for (let i = 0; i + 3 < path.length; i += 2) {
    const [ax, ay, bx, by] = [path[i] ?? 0, path[i + 1] ?? 0, path[i + 2] ?? 0, path[i + 3] ?? 0];
    const heading = Math.atan2(by - ay, bx - ax);
    if (i > 0) addBody(brush, ax, ay, heading);
    addBody(brush, bx, by, heading);
  }
  context.stroke();
  context.globalAlpha = 1;
}
