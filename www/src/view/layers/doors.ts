// The doors of the simulated world: a shut one is a leaf between two posts, an open one only the
// posts and a faint sill.

import { DOOR, DOOR_STRIDE } from "../../protocol/module.js";
import { addSegments, type Brush, disc, label, stroke } from "./layer.js";
import { writeName } from "./name.js";

/** A doorway narrower than this on the screen has no number, CSS pixels. */
const LEAST_NAMED = 14;

export function draw(brush: Brush): void {
  const { context, camera, palette, scene: { doors } } = brush;
  const colour = (context.fillStyle = palette.css.door);
  for (let i = 0; i + DOOR_STRIDE <= doors.length; i += DOOR_STRIDE) {
    const open = doors[i + DOOR.open] === 1;
    // A door that waits for the doorway to be clear is dashed.
    const waits = doors[i + DOOR.open] !== doors[i + DOOR.ordered];
    const ends = doors.subarray(i + DOOR.x1, i + DOOR.y2 + 1);
    stroke(brush, { colour, width: open ? 1.5 : 4, alpha: open ? 0.55 : 1, dash: open || waits ? [4, 4] : [] }, () => addSegments(context, ends));
    context.globalAlpha = 1;
    const [x1 = NaN, y1 = NaN, x2 = NaN, y2 = NaN] = ends;
    disc(brush, x1, y1, camera.px(3));
    disc(brush, x2, y2, camera.px(3));
    // The numbers of their buttons, where there is room for one.
    const width = Math.hypot(x2 - x1, y2 - y1);
    if (doors.length > DOOR_STRIDE && width * camera.scale > LEAST_NAMED) label(brush, (x1 + x2) / 2, (y1 + y2) / 2, () => writeName(brush, String(i / DOOR_STRIDE + 1), colour));
  }
}
