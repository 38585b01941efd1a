// Poses in the plane: x y heading, m and rad.

import type { Pose } from "./protocol.js";

export const NOWHERE: Pose = [0, 0, 0];

export function wrap(angle: number): number {
  return Math.atan2(Math.sin(angle), Math.cos(angle));
}

/** A point moved by the pose. */
export function place([px, py, heading]: Pose, x: number, y: number): [number, number] {
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  return [px + c * x - s * y, py + s * x + c * y];
}

/** A point moved by the inverse of the pose. */
export function takeBack([px, py, heading]: Pose, x: number, y: number): [number, number] {
  return place([0, 0, -heading], x - px, y - py);
}

/** `b` in the frame of `a`. */
export function between(a: Pose, b: Pose): Pose {
  const [x, y] = takeBack(a, b[0], b[1]);
  return [x, y, wrap(b[2] - a[2])];
}

/** Turned by an angle about a fixed point. */
export function turned(pose: Pose, by: number, [x, y]: readonly [number, number]): Pose {
  const [dx, dy] = place([0, 0, by], pose[0] - x, pose[1] - y);
  return [x + dx, y + dy, wrap(pose[2] + by)];
}

/** The mean of x y x y ..., or the origin. */
export function middle(points: Float64Array): [number, number] {
  let [x, y] = [0, 0];
  for (let i = 0; i + 1 < points.length; i += 2) {
    x += points[i] ?? 0;
    y += points[i + 1] ?? 0;
  }
  const count = Math.max(points.length / 2, 1);
  return [x / count, y / count];
}
