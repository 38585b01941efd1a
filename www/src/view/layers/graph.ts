// The pose graph: a node where each submap begins, joined to the next. A loose join is dashed,
// because only the motion makes it; the chosen one stands out.

import type { Submaps } from "../submaps.js";
import { addPolyline, type Brush, disc, nearestSegment, stroke } from "./layer.js";

export function draw(brush: Brush): void {
  const { context, camera, palette: { css }, scene: { submaps }, thing } = brush;
  const join = thing?.kind === "join" ? thing.submap : null;
  const places = Array.from({ length: submaps.count }, (_, i) => submaps.shown(i));
  const chosen = join !== null && join < places.length ? linesOf(submaps).subarray(4 * (join - 1), 4 * join) : null;
  if (chosen) stroke(brush, { colour: css.ink, width: 6, alpha: 0.9 }, () => addPolyline(context, chosen));
  for (const loose of [false, true]) {
    stroke(brush, { colour: css.ink, width: 1.6, alpha: 0.75, dash: loose ? [3, 4] : [] }, () => {
      for (let i = 1; i < places.length; i += 1) {
        const [from, to] = [places[i - 1], places[i]];
        if (from && to && submaps.isLoose(i) === loose) addPolyline(context, Float32Array.of(from[0], from[1], to[0], to[1]));
      }
    });
  }
  context.globalAlpha = 1;
  for (const [x, y] of places) {
    for (const [size, colour] of [[4.5, css.ink], [2.8, css.free]] as const) {
      context.fillStyle = colour;
      disc(brush, x, y, camera.px(size));
    }
  }
}

/** x1 y1 x2 y2 of each join, as drawn now; the first is that of submap 1 to submap 0. */
function linesOf(submaps: Submaps): Float32Array {
  const lines = new Float32Array(4 * Math.max(0, submaps.count - 1));
  for (let i = 1; i < submaps.count; i += 1) {
    const [from, to] = [submaps.shown(i - 1), submaps.shown(i)];
    lines.set([from[0], from[1], to[0], to[1]], 4 * (i - 1));
  }
  return lines;
}

/** The later submap of the join whose line is nearest to a map point, within `reach`, m. */
export function joinAt(submaps: Submaps, x: number, y: number, reach: number): number | null {
  const found = nearestSegment(linesOf(submaps), 4, 0, x, y, reach);
  return found === null ? null : found / 4 + 1;
}
