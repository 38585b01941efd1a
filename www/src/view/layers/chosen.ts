// The outline of what is being inspected, as given by the inspector.

import { type Brush, stroke } from "./layer.js";

export function draw(brush: Brush): void {
  const { context, palette: { css }, outline } = brush;
  context.lineJoin = context.lineCap = "round";
  for (const [colour, width] of [[css.ink, 5], [css.free, 3.4], [css.path, 2.2]] as const) {
    stroke(brush, { colour, width }, () => {
      for (const way of outline) way.forEach(([x, y], i) => (i === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
    });
  }
}
