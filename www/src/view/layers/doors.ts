// The doors of the simulated world: shut they are a leaf between two posts, open only the posts and
// a faint sill.

import { DOOR, DOOR_STRIDE } from "../../protocol/module.js";
import type { Brush } from "./layer.js";

export function draw({ context, camera, palette, scene: { doors } }: Brush): void {
  context.strokeStyle = context.fillStyle = palette.css.door;
  for (let i = 0; i + DOOR_STRIDE <= doors.length; i += DOOR_STRIDE) {
    const at = (place: number): number => doors[i + place] ?? NaN;
    const open = at(DOOR.open) === 1;
    // A door that waits for the doorway to be clear is dashed.
    const waits = at(DOOR.open) !== at(DOOR.ordered);
    context.lineWidth = camera.px(open ? 1.5 : 4);
    context.globalAlpha = open ? 0.55 : 1;
    context.setLineDash(open || waits ? [camera.px(4), camera.px(4)] : []);
    context.beginPath();
    context.moveTo(at(DOOR.x1), at(DOOR.y1));
    context.lineTo(at(DOOR.x2), at(DOOR.y2));
    context.stroke();
    context.setLineDash([]);
    context.globalAlpha = 1;
    for (const [x, y] of [[at(DOOR.x1), at(DOOR.y1)], [at(DOOR.x2), at(DOOR.y2)]] as const) {
      context.beginPath();
      context.arc(x, y, camera.px(3), 0, 2 * Math.PI);
      context.fill();
    }
  }
}

/** The door whose leaf is nearest to a map point, if it is nearer than `reach`, m; its number. */
export function doorAt(doors: Float32Array, x: number, y: number, reach: number): number | null {
  let [nearest, found] = [reach, null as number | null];
  for (let i = 0; i + DOOR_STRIDE <= doors.length; i += DOOR_STRIDE) {
    const at = (place: number): number => doors[i + place] ?? NaN;
    const [dx, dy] = [at(DOOR.x2) - at(DOOR.x1), at(DOOR.y2) - at(DOOR.y1)];
    const part = ((x - at(DOOR.x1)) * dx + (y - at(DOOR.y1)) * dy) / (dx * dx + dy * dy || 1);
    const along = Math.min(Math.max(part, 0), 1);
    const distance = Math.hypot(x - at(DOOR.x1) - along * dx, y - at(DOOR.y1) - along * dy);
    if (distance < nearest) [nearest, found] = [distance, i / DOOR_STRIDE];
  }
  return found;
}
