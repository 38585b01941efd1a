// The true walls and everything that moves: only a simulation has them; dashed because the robot
// never sees them.
//
// Glass and dark walls differ in colour and in dash from those that every sensor sees.

import type { Box } from "../camera.js";
import type { Palette } from "../palette.js";
import { type Brush, disc } from "./layer.js";

/** Walls drawn with dashes at most: of a whole town nobody would see them, and they cost more than
    the walls. */
const MOST_DASHED = 5000;

/** Colour, dash and width in pixels, by material: opaque, glass, dark. */
const STYLES = [
  { colour: "truth", dash: [5, 3], width: 1.5 },
  { colour: "glass", dash: [9, 3, 2, 3], width: 2.5 },
  { colour: "dark", dash: [2, 2.5], width: 3 },
] as const;

/** Draws the walls within `box` into a context that draws in metres; `pixel` is the size of a CSS
    pixel, m. */
export function drawWalls(context: CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D, walls: Float32Array, materials: Uint8Array, box: Box, pixel: number, palette: Palette): void {
  const dashed = walls.length / 4 < MOST_DASHED;
  STYLES.forEach(({ colour, dash, width }, material) => {
    context.beginPath();
    let any = false;
    for (let i = 0; i + 3 < walls.length; i += 4) {
      if ((materials[i / 4] ?? 0) !== material) continue;
      const [x1 = 0, y1 = 0, x2 = 0, y2 = 0] = [walls[i], walls[i + 1], walls[i + 2], walls[i + 3]];
      if ((x1 < box.minX && x2 < box.minX) || (x1 > box.maxX && x2 > box.maxX) || (y1 < box.minY && y2 < box.minY) || (y1 > box.maxY && y2 > box.maxY)) continue;
      context.moveTo(x1, y1);
      context.lineTo(x2, y2);
      any = true;
    }
    if (!any) return;
    context.strokeStyle = palette.css[colour];
    context.lineWidth = pixel * (dashed ? width : 1);
    context.setLineDash(dashed ? dash.map((length) => pixel * length) : []);
    context.stroke();
  });
}

/** People: a disc with a head, so that nobody takes them for pillars. */
export function drawMovers(brush: Brush): void {
  const { context, camera, palette, scene: { movers } } = brush;
  context.lineWidth = camera.px(1.5);
  context.strokeStyle = context.fillStyle = palette.css.people;
  for (let i = 0; i + 2 < movers.length; i += 3) {
    const [x = 0, y = 0, radius = 0] = [movers[i], movers[i + 1], movers[i + 2]];
    context.globalAlpha = 0.28;
    disc(brush, x, y, radius);
    context.globalAlpha = 0.9;
    context.stroke();
    disc(brush, x, y, 0.4 * radius);
  }
}
