// Whether a robot could leave a drawing: the walls around it have a gap somewhere.

import { type Drawing, partAt, partsOf, type Point } from "./drawing.js";
import { lineOf } from "./outline.js";

/** Cell size, m: no robot passes through a narrower gap. Larger worlds get coarser cells. */
const CELL = 0.1;
const MOST_CELLS = 250_000;
/** Free cells around the whole drawing. */
const MARGIN = 2;

/** Whether a path leads from the start to the outside. Shut doors are walls; open ones lead to
    where somebody drew them. */
export function isOpenWorld(drawing: Drawing): boolean {
  const lines = wallsOf(drawing);
  if (lines.length === 0) return false;
  const { x, y } = drawing.start;
  const all: readonly Point[] = [[x, y], ...lines.flat()];
  const [left, right] = [Math.min(...all.map(([px]) => px)), Math.max(...all.map(([px]) => px))];
  const [low, high] = [Math.min(...all.map(([, py]) => py)), Math.max(...all.map(([, py]) => py))];
  const cell = Math.max(CELL, Math.sqrt(((right - left) * (high - low)) / MOST_CELLS));
  const [columns, rows] = [Math.ceil((right - left) / cell) + 2 * MARGIN + 1, Math.ceil((high - low) / cell) + 2 * MARGIN + 1];
  if (!Number.isFinite(columns * rows) || columns * rows > 2 * MOST_CELLS) return false;
  const at = ([px, py]: Point): number => (Math.floor((py - low) / cell) + MARGIN) * columns + Math.floor((px - left) / cell) + MARGIN;
  const taken = new Uint8Array(columns * rows);
  for (const [a, b] of lines) {
    const steps = Math.max(1, Math.ceil((2 * Math.hypot(b[0] - a[0], b[1] - a[1])) / cell));
    for (let i = 0; i <= steps; i += 1) taken[at([a[0] + ((b[0] - a[0]) * i) / steps, a[1] + ((b[1] - a[1]) * i) / steps])] = 1;
  }
  return reachesEdge(taken, columns, rows, at([x, y]));
}

/** Straight pieces of everything that encloses a robot; a post alone does not. */
function wallsOf(drawing: Drawing): (readonly [Point, Point])[] {
  return partsOf(drawing).flatMap((ref) => {
    const part = partAt(drawing, ref);
    if (part?.kind !== "obstacle" && part?.kind !== "door") return [];
    const { points, closed } = lineOf(part);
    return points.flatMap((point, i) => {
      const next = points[i + 1] ?? (closed ? points[0] : undefined);
      return next ? [[point, next] as const] : [];
    });
  });
}

/** Moves only between cells that share a side, so that nothing slips through a diagonal wall. */
function reachesEdge(taken: Uint8Array, columns: number, rows: number, start: number): boolean {
  const open = [start];
  // A start inside a wall is reported elsewhere.
  if (taken[start] === 1) return false;
  taken[start] = 1;
  for (let cell = open.pop(); cell !== undefined; cell = open.pop()) {
    const [column, row] = [cell % columns, Math.floor(cell / columns)];
    if (column === 0 || row === 0 || column === columns - 1 || row === rows - 1) return true;
    for (const next of [cell - 1, cell + 1, cell - columns, cell + columns]) {
      if (taken[next] === 1) continue;
      taken[next] = 1;
      open.push(next);
    }
  }
  return false;
}
