// The true walls and everything that moves: only a simulation has them. Dashed, because the robot
// never sees them.
//
// Glass and dark walls differ in colour and dashes from those that every sensor sees.

import { type Brush, disc } from "./layer.js";

/** Most walls drawn with dashes: in a whole town dashes would be invisible, and cost more than the
    walls. */
const MOST_DASHED = 5000;

/** Colour, dash and width in pixels, by material: opaque, glass, dark. */
const STYLES = [
  { colour: "truth", dash: [5, 3], width: 1.5 },
  { colour: "glass", dash: [9, 3, 2, 3], width: 2.5 },
  { colour: "dark", dash: [2, 2.5], width: 3 },
] as const;

/** The walls of a world, sorted by material; a world is sent only once. */
const sorted = new WeakMap<Float32Array, { readonly materials: Uint8Array; readonly walls: readonly Float32Array[] }>();

function byMaterial(truth: Float32Array, materials: Uint8Array): readonly Float32Array[] {
  const known = sorted.get(truth);
  if (known?.materials === materials) return known.walls;
  const walls = STYLES.map((_, material) => {
    const rows = Array.from({ length: truth.length >> 2 }, (_, i) => i).filter((i) => (materials[i] ?? 0) === material);
    const ends = new Float32Array(4 * rows.length);
    rows.forEach((row, i) => ends.set(truth.subarray(4 * row, 4 * row + 4), 4 * i));
    return ends;
  });
  sorted.set(truth, { materials, walls });
  return walls;
}

export function drawWalls({ bulk, palette, scene: { truth, materials } }: Brush): void {
  const isDashed = truth.length / 4 < MOST_DASHED;
  byMaterial(truth, materials).forEach((ends, material) => {
    const style = STYLES[material];
    if (style && ends.length > 0) bulk.segments(ends, { colour: palette.css[style.colour], width: isDashed ? style.width : 1, dash: isDashed ? style.dash : [] });
  });
}

/** Walkers: a disc with a head, so that it does not look like a pillar. */
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
