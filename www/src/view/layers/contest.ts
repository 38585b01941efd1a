// A contest of planners: the tree of the watched one, all paths, start and goal.

import type { PaletteName } from "../palette.js";
import { drawGhosts } from "./body.js";
import { addPolyline, addSegments, type Brush, disc, stroke } from "./layer.js";

/** The colours of the planners, in their order. */
export const CONTEST_COLOURS = ["contest0", "contest1", "contest2", "contest3", "contest4", "contest5", "contest6", "contest7", "contest8"] as const satisfies readonly PaletteName[];

export function draw(brush: Brush): void {
  const { context, palette, contest } = brush;
  if (!contest) return;
  const { found, start, goal } = contest;
  context.lineJoin = context.lineCap = "round";
  const colour = (place: number): string => palette.css[CONTEST_COLOURS[place] ?? "ink"];
  if (found) {
    stroke(brush, { colour: colour(found.watched), width: 1, alpha: 0.65 }, () => addSegments(context, found.tree));
    const last = (place: number): number => (place === found.watched ? 1 : 0);
    const order = found.entrants.map((_, place) => place).sort((a, b) => last(a) - last(b));
    for (const place of order) {
      const entrant = found.entrants[place];
      if (!entrant) continue;
      const { planner, path } = entrant;
      const strokes = place === found.watched ? [[palette.css.free, 7], [colour(place), 4]] as const : [[colour(place), 1.8]] as const;
      for (const [colour, width] of strokes) stroke(brush, { colour, width }, () => addPolyline(context, path));
      if (place === found.watched && planner === "outline") drawGhosts(brush, path, colour(place));
    }
  }
  context.globalAlpha = 1;
  if (start) pin(brush, start, false);
  if (goal) pin(brush, goal, true);
}

/** The start is an open ring, the goal a filled one. */
function pin(brush: Brush, [x, y]: readonly [number, number], filled: boolean): void {
  const { context, camera, palette: { css: { free: paper, ink } } } = brush;
  const radius = camera.px(7);
  for (const [size, style] of [[radius * 1.35, paper], [radius, ink], [radius * 0.62, filled ? ink : paper], [filled ? radius * 0.5 : 0, paper], [filled ? radius * 0.28 : 0, ink]] as const) {
    context.fillStyle = style;
    disc(brush, x, y, size);
  }
}
