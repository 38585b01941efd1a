// A name on the map, with a background.

import type { Brush } from "./layer.js";

/** Beside the point that is being labelled. */
export function writeName({ context, palette }: Brush, name: string, colour = palette.css.ink): void {
  context.font = "500 12px IBM Plex Mono, monospace";
  const { width } = context.measureText(name);
  context.globalAlpha = 0.9;
  context.fillStyle = palette.css.free;
  context.beginPath();
  context.roundRect(8, -24, width + 10, 19, 5);
  context.fill();
  context.globalAlpha = 1;
  context.fillStyle = colour;
  context.fillText(name, 13, -10.5);
}
