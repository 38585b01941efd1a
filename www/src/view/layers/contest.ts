// A contest of planners: the tree of the one that is watched, all paths, start and goal.

import type { PaletteName } from "../palette.js";
import { drawGhosts } from "./body.js";
import { addPolyline, addSegments, type Brush } from "./layer.js";

/** The colours of the planners, in their order. */
export const CONTEST_COLOURS = ["contest0", "contest1", "contest2", "contest3", "contest4", "contest5", "contest6", "contest7", "contest8"] as const satisfies readonly PaletteName[];

export function draw(brush: Brush): void {
  const { context, camera, palette, contest } = brush;
  if (!contest) return;
  const { found, start, goal } = contest;
  context.lineJoin = context.lineCap = "round";
  const colour = (place: number): string => palette.css[CONTEST_COLOURS[place] ?? "ink"];
  if (found) {
    context.strokeStyle = colour(found.watched);
    context.lineWidth = camera.px(1);
    context.globalAlpha = 0.65;
    context.beginPath();
    addSegments(context, found.tree);
    context.stroke();
    context.globalAlpha = 1;
    const last = (place: number): number => (place === found.watched ? 1 : 0);
    const order = found.entrants.map((_, place) => place).sort((a, b) => last(a) - last(b));
    for (const place of order) {
      const entrant = found.entrants[place];
      if (!entrant) continue;
      const { planner, path } = entrant;
      const strokes = place === found.watched ? [[palette.css.free, 7], [colour(place), 4]] as const : [[colour(place), 1.8]] as const;
      for (const [style, width] of strokes) {
        context.strokeStyle = style;
        context.lineWidth = camera.px(width);
        context.beginPath();
        addPolyline(context, path);
        context.stroke();
      }
      if (place === found.watched && planner === "outline") drawGhosts(brush, path, colour(place));
    }
  }
  if (start) pin(context, start, camera.px(7), palette.css.free, palette.css.ink, false);
  if (goal) pin(context, goal, camera.px(7), palette.css.free, palette.css.ink, true);
}

/** The start is an open ring, the goal a filled one. */
function pin(context: CanvasRenderingContext2D, [x, y]: readonly [number, number], radius: number, paper: string, ink: string, filled: boolean): void {
  for (const [size, style] of [[radius * 1.35, paper], [radius, ink], [radius * 0.62, filled ? ink : paper], [filled ? radius * 0.5 : 0, filled ? paper : ink], [filled ? radius * 0.28 : 0, ink]] as const) {
    if (size === 0) continue;
    context.fillStyle = style;
    context.beginPath();
    context.arc(x, y, size, 0, 2 * Math.PI);
    context.fill();
  }
}
