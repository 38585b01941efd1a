// The walls highlighted from the matrix or the list of matches, with their names; for a chosen one
// also the lines of the last scan that were compared with it.

import { LINE, LINE_STRIDE } from "../../protocol/module.js";
import { t } from "../../words.js";
import { addSegments, type Brush, label, stroke } from "./layer.js";
import { writeName } from "./name.js";

export function draw(brush: Brush): void {
  const { context, palette, scene: { lines }, spot, sightings } = brush;
  context.lineCap = "round";
  const line = (ends: ArrayLike<number>, colour: string, width: number): void => stroke(brush, { colour, width }, () => addSegments(context, ends));
  for (const sighting of sightings) {
    if (sighting.candidates.some((c) => c.wall === spot.pinned) || sighting.wall === spot.pinned) line(sighting.ends, palette.css.scan, 7);
  }
  for (let i = 0; i + LINE_STRIDE <= lines.length; i += LINE_STRIDE) {
    const id = lines[i + LINE.id] ?? NaN;
    const isPinned = id === spot.pinned;
    if (!isPinned && !spot.hovered.includes(id)) continue;
    const ends = lines.subarray(i + LINE.x1, i + LINE.y2 + 1);
    line(ends, palette.css.ink, 9);
    line(ends, isPinned ? palette.css.path : palette.css.frontiers, 5);
    const [x1 = NaN, y1 = NaN, x2 = NaN, y2 = NaN] = ends;
    label(brush, (x1 + x2) / 2, (y1 + y2) / 2, () => writeName(brush, t`wall ${id}`));
  }
}

/** Ends of a wall, x1 y1 x2 y2, map frame, m; null if there is none with that identifier. */
export function wallEnds(lines: Float64Array, id: number): number[] | null {
  for (let i = 0; i + LINE_STRIDE <= lines.length; i += LINE_STRIDE) {
    if (lines[i + LINE.id] === id) return [...lines.subarray(i + LINE.x1, i + LINE.y2 + 1)];
  }
  return null;
}
