// Where the robot was: in truth (dashed), by its wheels alone (dotted), and as estimated (solid).

import { TRAIL_STRIDE } from "../../protocol/module.js";
import type { Brush } from "./layer.js";

export function draw({ context, camera, palette, scene }: Brush): void {
  const pixel = camera.px(1.5);
  const trail = (offset: number, colour: string, width: number, dash: number[]): void => {
    context.strokeStyle = colour;
    context.lineWidth = camera.px(width);
    context.lineJoin = "round";
    context.setLineDash(dash.map((length) => camera.px(length)));
    context.beginPath();
    let pen = false;
    let [lastX, lastY] = [NaN, NaN];
    for (let i = offset; i + 1 < scene.trailLength; i += TRAIL_STRIDE) {
      const [x = NaN, y = NaN] = [scene.trail[i], scene.trail[i + 1]];
      if (Number.isNaN(x)) {
        pen = false;
        continue;
      }
      // Points that fall on the same pixel cost as much as others and show nothing.
      if (pen && Math.abs(x - lastX) + Math.abs(y - lastY) < pixel) continue;
      if (pen) context.lineTo(x, y);
      else context.moveTo(x, y);
      [pen, lastX, lastY] = [true, x, y];
    }
    context.stroke();
  };
  context.globalAlpha = 0.8;
  trail(2, palette.css.odometry, 1.5, [1.5, 3.5]);
  trail(0, palette.css.truth, 2, [6, 4]);
  trail(4, palette.css.estimate, 2, []);
  context.globalAlpha = 1;
  context.setLineDash([]);
}
