// The trajectory: true (dashed), by odometry alone (dotted), and estimated (solid).

import { TRAIL, TRAIL_STRIDE } from "../../protocol/module.js";
import { moved, type Shift } from "../submaps.js";
import { type Brush, stroke } from "./layer.js";

/** A jump longer than this, m, and faster than MOST_SPEED, m/s, was not driven: the robot was
    carried elsewhere, or relocalised. */
const LEAST_CARRIED = 1;
const MOST_SPEED = 5;
/** Points closer together than this, CSS pixels, cost as much as others and are hardly visible. */
const LEAST_PIXELS = 3;

export function draw(brush: Brush): void {
  drawFrom(brush, 0);
}

/** The part driven since [`draw`], which is not called for every picture. */
export function drawEnd(brush: Brush): void {
  drawFrom(brush, Math.max(0, brush.recordedTrail - TRAIL_STRIDE));
}

/** Draws the trail from an index on. */
function drawFrom(brush: Brush, begin: number): void {
  const { context, camera, palette, scene } = brush;
  const least = camera.px(LEAST_PIXELS);
  // Round corners take twice as long, and are invisible on such thin lines.
  context.miterLimit = 2;
  const { submaps } = scene;
  // While the map glides, the trajectory glides with it.
  const shifts = submaps.glides ? Array.from({ length: submaps.count }, (_, i) => submaps.shift(i)) : [];
  const addTrail = (offset: number, shifts: readonly (Shift | null)[] = []): void => {
    let pen = false;
    let [lastX, lastY, lastTime] = [NaN, NaN, NaN];
    for (let i = begin + offset; i + 1 < scene.trailLength; i += TRAIL_STRIDE) {
      let [x = NaN, y = NaN] = [scene.trail[i], scene.trail[i + 1]];
      const shift = shifts[scene.trail[i - offset + TRAIL.submap] ?? 0];
      if (shift) [x, y] = moved(shift, x, y);
      if (Number.isNaN(x)) {
        pen = false;
        continue;
      }
      const time = scene.trail[i - offset + TRAIL.time] ?? NaN;
      const way = Math.hypot(x - lastX, y - lastY);
      const isCarried = way > LEAST_CARRIED && way > MOST_SPEED * (time - lastTime);
      lastTime = time;
      if (pen && Math.abs(x - lastX) + Math.abs(y - lastY) < least) continue;
      if (pen && !isCarried) context.lineTo(x, y);
      else context.moveTo(x, y);
      [pen, lastX, lastY] = [true, x, y];
    }
  };
  stroke(brush, { colour: palette.css.odometry, width: 1, alpha: 0.9, dash: [1.5, 3.5] }, () => addTrail(TRAIL.odometryX));
  if (brush.truth) stroke(brush, { colour: palette.css.truth, width: 2, alpha: 0.8, dash: [6, 4] }, () => addTrail(TRAIL.truthX));
  stroke(brush, { colour: palette.css.estimate, width: 2, alpha: 0.8 }, () => addTrail(TRAIL.x, shifts));
}
