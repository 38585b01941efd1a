// Where the robot may be while it is not localised: an arrowhead for each pose, darker if more
// likely, over the particles behind them. Particles with maps are always drawn.

import { HYPOTHESIS, HYPOTHESIS_STRIDE } from "../../protocol/module.js";
import { addShape } from "./body.js";
import { type Brush, stroke } from "./layer.js";

export function draw(brush: Brush): void {
  const { context, camera, palette, scene: { hypotheses, particles, status } } = brush;
  if (hypotheses.length === 0 && particles.length === 0) return;
  context.fillStyle = palette.css.hypotheses;
  context.globalAlpha = 0.5;
  const size = camera.px(2);
  for (let i = 0; i + 1 < particles.length; i += 2) {
    context.fillRect((particles[i] ?? 0) - size / 2, (particles[i + 1] ?? 0) - size / 2, size, size);
  }
  const half = Math.max(status?.halfLength ?? 0.1, camera.px(11));
  // The most likely last, on top.
  for (let i = hypotheses.length - HYPOTHESIS_STRIDE; i >= 0; i -= HYPOTHESIS_STRIDE) {
    const at = (place: number): number => hypotheses[i + place] ?? 0;
    context.beginPath();
    addShape(context, at(HYPOTHESIS.x), at(HYPOTHESIS.y), at(HYPOTHESIS.heading), [[half, 0], [-half, half * 0.75], [-half * 0.5, 0], [-half, -half * 0.75]]);
    context.globalAlpha = 0.15 + 0.75 * at(HYPOTHESIS.weight);
    context.fill();
    stroke(brush, { colour: palette.css.hypotheses, width: 1.2 }, () =>
      addShape(context, at(HYPOTHESIS.x), at(HYPOTHESIS.y), at(HYPOTHESIS.heading), [[half, 0], [-half, half * 0.75], [-half * 0.5, 0], [-half, -half * 0.75]]));
  }
}
