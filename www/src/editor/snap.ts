// Snaps a point: to the end of another wall, straight on or at a right angle, or to the grid.
// Snapping can be suspended.

import type { Point } from "./drawing.js";
import { distance } from "./outline.js";

export interface SnapAid {
  /** Ends and corners that a point may snap to. */
  readonly ends: readonly Point[];
  /** The point that the line is drawn from, and the one before that. */
  readonly from: Point | null;
  readonly before: Point | null;
  /** Width of a cell of the grid, m. */
  readonly grid: number;
  /** Distance within which a point snaps, m. */
  readonly reach: number;
}

export interface Snapped {
  readonly point: Point;
  readonly to: "end" | "angle" | "grid" | "nothing";
}

/** Ends come before right angles, and these before the grid. */
export function snapped(point: Point, aid: SnapAid | null): Snapped {
  if (!aid) return { point, to: "nothing" };
  const { ends, grid, reach } = aid;
  const nearest = ends.reduce<Point | null>((best, end) => (distance(end, point) < (best ? distance(best, point) : reach) ? end : best), null);
  if (nearest) return { point: nearest, to: "end" };
  return atAngle(point, aid) ?? { point: [onGrid(point[0], grid), onGrid(point[1], grid)], to: "grid" };
}

/** Along the last wall, across it, or along an axis; its length is a whole number of cells. */
function atAngle(point: Point, { from, before, grid, reach }: SnapAid): Snapped | null {
  if (!from) return null;
  const [dx, dy] = [point[0] - from[0], point[1] - from[1]];
  const last = before ? Math.atan2(from[1] - before[1], from[0] - before[0]) : 0;
  for (const angle of [0, Math.PI / 2, last, last + Math.PI / 2]) {
    const [ux, uy] = [Math.cos(angle), Math.sin(angle)];
    if (Math.abs(ux * dy - uy * dx) > reach) continue;
    const along = onGrid(ux * dx + uy * dy, grid);
    if (along === 0) continue;
    return { point: [tidy(from[0] + along * ux), tidy(from[1] + along * uy)], to: "angle" };
  }
  return null;
}

export function onGrid(value: number, grid: number): number {
  return tidy(Math.round(value / grid) * grid);
}

/** Rounds to a tenth of a millimetre, without the tails of binary fractions. */
export function tidy(value: number): number {
  return Math.round(value * 1e4) / 1e4 + 0;
}

/** A grid cell large enough to be seen at this magnification (pixels per metre), m. */
export function gridOf(scale: number): number {
  return scale >= 90 ? 0.05 : scale >= 36 ? 0.1 : scale >= 14 ? 0.25 : scale >= 6 ? 0.5 : 1;
}
