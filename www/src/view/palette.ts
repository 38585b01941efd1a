// The colours of the map, read from the style sheet so that page, legend and canvas cannot
// disagree. Hues from Okabe & Ito (2008), safe for the common kinds of colour blindness; line
// styles differ as well.

import { colourOf } from "../ui/plot_style.js";

const NAMES = [
  "unknown", "free", "occupied", "gridline", "truth", "odometry", "estimate", "robot", "scan", "walls", "lines", "path", "tree",
  "frontiers", "ink", "glass", "dark", "people", "found", "points", "landmarks", "moving", "door", "twin", "prior", "hypotheses", "field", "accepted", "waiting", "refused", "revoked", "torn",
  "contest0", "contest1", "contest2", "contest3", "contest4", "contest5", "contest6", "contest7", "contest8",
] as const;

export type PaletteName = (typeof NAMES)[number];
export type Rgb = readonly [number, number, number];

export interface Palette {
  /** CSS colours. */
  readonly css: Readonly<Record<PaletteName, string>>;
  /** The tones of the grid's pixels. */
  readonly tones: { readonly unknown: Rgb; readonly free: Rgb; readonly occupied: Rgb };
}

/** Resolves the custom properties `--map-…` in the present theme. */
export function readPalette(): Palette {
  const probe = document.createElement("i");
  probe.hidden = true;
  document.body.append(probe);
  const css = Object.fromEntries(NAMES.map((name) => [name, colourOf(probe, `map-${name}`)])) as Record<PaletteName, string>;
  probe.remove();
  return { css, tones: { unknown: rgb(css.unknown), free: rgb(css.free), occupied: rgb(css.occupied) } };
}

export function rgb(css: string): Rgb {
  const [r = 128, g = 128, b = 128] = (css.match(/[\d.]+/g) ?? []).map(Number);
  return [r, g, b];
}
