// The pose graph: a node where each submap begins, joined to the next. A join that only the motion
// makes is dashed.

import { addPolyline, type Brush, disc, stroke } from "./layer.js";

export function draw(brush: Brush): void {
  const { context, camera, palette: { css }, scene: { submaps } } = brush;
  const places = Array.from({ length: submaps.count }, (_, i) => submaps.shown(i));
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
