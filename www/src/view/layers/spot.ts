// The walls that are pointed at in the matrix or the list of matches, with their names; for a
// chosen one the lines of the last scan that were compared with it.

import { LINE, LINE_STRIDE } from "../../protocol/module.js";
import type { Brush } from "./layer.js";

export function draw(brush: Brush): void {
  const { context, camera, palette, scene, spot, sightings } = brush;
  context.lineCap = "round";
  for (const sighting of sightings) {
    if (!sighting.candidates.some((c) => c.wall === spot.pinned) && sighting.wall !== spot.pinned) continue;
    const [x1, y1, x2, y2] = sighting.ends;
    stroke(brush, [x1, y1, x2, y2], palette.css.scan, 7);
  }
  const { lines } = scene;
  for (let i = 0; i + LINE_STRIDE <= lines.length; i += LINE_STRIDE) {
    const at = (place: number): number => lines[i + place] ?? NaN;
    const id = at(LINE.id);
    const isPinned = id === spot.pinned;
    if (!isPinned && !spot.hovered.includes(id)) continue;
    const ends = [at(LINE.x1), at(LINE.y1), at(LINE.x2), at(LINE.y2)] as const;
    stroke(brush, ends, palette.css.ink, 9);
    stroke(brush, ends, isPinned ? palette.css.path : palette.css.frontiers, 5);
    label(context, camera.toScreen((ends[0] + ends[2]) / 2, (ends[1] + ends[3]) / 2), camera.ratio, `wall ${id}`, palette.css.ink, palette.css.free);
  }
}

function stroke({ context, camera }: Brush, [x1, y1, x2, y2]: readonly [number, number, number, number], colour: string, width: number): void {
  context.strokeStyle = colour;
  context.lineWidth = camera.px(width);
  context.beginPath();
  context.moveTo(x1, y1);
  context.lineTo(x2, y2);
  context.stroke();
}

/** Text stands upright: it is written in pixels, not in metres. */
function label(context: CanvasRenderingContext2D, [x, y]: readonly [number, number], ratio: number, text: string, ink: string, paper: string): void {
  context.save();
  context.setTransform(ratio, 0, 0, ratio, x * ratio, y * ratio);
  context.font = "500 12px IBM Plex Mono, monospace";
  const width = context.measureText(text).width;
  context.globalAlpha = 0.9;
  context.fillStyle = paper;
  context.beginPath();
  context.roundRect(8, -24, width + 10, 19, 5);
  context.fill();
  context.globalAlpha = 1;
  context.fillStyle = ink;
  context.fillText(text, 13, -10.5);
  context.restore();
}

/** Ends of a wall, x1 y1 x2 y2, map frame, m; null where there is none of that name. */
export function wallEnds(lines: Float64Array, id: number): number[] | null {
  for (let i = 0; i + LINE_STRIDE <= lines.length; i += LINE_STRIDE) {
    if (lines[i + LINE.id] === id) return [...lines.subarray(i + LINE.x1, i + LINE.y2 + 1)];
  }
  return null;
}

/** The wall whose seen part is nearest to a map point, if it is nearer than `reach`, m. */
export function wallAt(lines: Float64Array, x: number, y: number, reach: number): number | null {
  let [nearest, found] = [reach, null as number | null];
  for (let i = 0; i + LINE_STRIDE <= lines.length; i += LINE_STRIDE) {
    const at = (place: number): number => lines[i + place] ?? NaN;
    const [dx, dy] = [at(LINE.x2) - at(LINE.x1), at(LINE.y2) - at(LINE.y1)];
    const part = ((x - at(LINE.x1)) * dx + (y - at(LINE.y1)) * dy) / (dx * dx + dy * dy || 1);
    const along = Math.min(Math.max(part, 0), 1);
    const distance = Math.hypot(x - at(LINE.x1) - along * dx, y - at(LINE.y1) - along * dy);
    if (distance < nearest) [nearest, found] = [distance, at(LINE.id)];
  }
  return found;
}
