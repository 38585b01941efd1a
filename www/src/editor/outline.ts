// The geometry of the parts of a drawing: their corners, the distance to a place, the bounding box.

import type { Box } from "../view/camera.js";
import { type Drawing, type Obstacle, type Part, partAt, type PartRef, partsOf, type Point, sameRef } from "./drawing.js";

/** Radius of the circle that represents robot and goal, m. */
export const MARK_RADIUS = 0.15;

export function turned([x, y]: Point, angle: number): Point {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [c * x - s * y, s * x + c * y];
}

export const plus = ([ax, ay]: Point, [bx, by]: Point): Point => [ax + bx, ay + by];
export const minus = ([ax, ay]: Point, [bx, by]: Point): Point => [ax - bx, ay - by];
export const distance = ([ax, ay]: Point, [bx, by]: Point): number => Math.hypot(ax - bx, ay - by);

/** Corners of an obstacle; a circle has none. */
export function cornersOf(obstacle: Obstacle): readonly Point[] {
  if (obstacle.shape === "circle") return [];
  if (obstacle.shape !== "rectangle") return obstacle.points;
  const { centre, size: [width, height], angle = 0 } = obstacle;
  return ([[-1, -1], [1, -1], [1, 1], [-1, 1]] as const).map(([x, y]) => plus(centre, turned([x * width / 2, y * height / 2], angle)));
}

/** Its points as a line, whether the last joins the first, and its radius. */
export function lineOf(part: Part): { points: readonly Point[]; closed: boolean; radius: number } {
  switch (part.kind) {
    case "obstacle": {
      const { value } = part;
      if (value.shape === "circle") return { points: [value.centre], closed: false, radius: value.radius };
      return { points: cornersOf(value), closed: value.shape !== "polyline" || (value.closed ?? false), radius: 0 };
    }
    case "door": return { points: [part.value.from, part.value.to], closed: false, radius: 0 };
    case "mover": return { points: part.value.waypoints, closed: part.value.closed ?? false, radius: part.value.radius };
    default: return { points: [[part.value.x, part.value.y]], closed: false, radius: MARK_RADIUS };
  }
}

function toSegment(p: Point, a: Point, b: Point): number {
  const [dx, dy] = minus(b, a);
  const length2 = dx * dx + dy * dy;
  const t = length2 > 0 ? Math.min(Math.max(((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length2, 0), 1) : 0;
  return distance(p, [a[0] + t * dx, a[1] + t * dy]);
}

function holds(points: readonly Point[], [x, y]: Point): boolean {
  let inside = false;
  points.forEach(([ax, ay], i) => {
    const [bx, by] = points[(i + 1) % points.length] as Point;
    if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) inside = !inside;
  });
  return inside;
}

/** Distance from a place to a part, m; 0 within a solid. */
export function distanceTo(part: Part, place: Point): number {
  const { points, closed, radius } = lineOf(part);
  const isSolid = part.kind === "obstacle" && part.value.shape !== "polyline";
  if (isSolid && points.length > 2 && holds(points, place)) return 0;
  const ends = closed ? points : points.slice(0, -1);
  const sides = ends.map((a, i) => toSegment(place, a, points[(i + 1) % points.length] as Point));
  const first = points[0] ? Math.max(distance(place, points[0]) - radius, 0) : Infinity;
  return Math.min(first, ...sides);
}

/** The nearest part within `reach` (m) of a place; of equally near ones the one on top. */
export function partNear(drawing: Drawing, place: Point, reach: number): PartRef | null {
  let [best, least]: [PartRef | null, number] = [null, reach];
  for (const ref of partsOf(drawing)) {
    const part = partAt(drawing, ref);
    const far = part ? distanceTo(part, place) : Infinity;
    if (far <= least) [best, least] = [ref, far];
  }
  return best;
}

/** Ends and corners of all parts except one, for others to snap to. */
export function endsOf(drawing: Drawing, but: PartRef | null): Point[] {
  const ends: Point[] = [];
  for (const ref of partsOf(drawing)) {
    if (ref.kind === "mover" || ref.kind === "start" || ref.kind === "goal" || sameRef(ref, but)) continue;
    const part = partAt(drawing, ref);
    if (part) ends.push(...lineOf(part).points);
  }
  return ends;
}

/** The bounding box of everything; if there is nothing, that of an empty floor of 8 x 6 m. */
export function boxOf(drawing: Drawing): Box {
  const { x, y } = drawing.start;
  const box = { minX: x, minY: y, maxX: x, maxY: y };
  for (const ref of partsOf(drawing)) {
    const part = partAt(drawing, ref);
    if (!part) continue;
    const { points, radius } = lineOf(part);
    for (const [px, py] of points) {
      box.minX = Math.min(box.minX, px - radius);
      box.minY = Math.min(box.minY, py - radius);
      box.maxX = Math.max(box.maxX, px + radius);
      box.maxY = Math.max(box.maxY, py + radius);
    }
  }
  if (box.maxX - box.minX > 1 || box.maxY - box.minY > 1) return box;
  return { minX: x - 4, minY: y - 3, maxX: x + 4, maxY: y + 3 };
}
