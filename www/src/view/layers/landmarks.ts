// Landmarks of the filter or of the submaps, each in a circle that grows with its confidence: how
// often it was found again (Pilch 2016 §3.5.2, fig. 3.13). Corners and posts with the ellipse in
// which they lie with 95 % probability; a wall has its band, and its circle stands on its middle.

import { LANDMARK, LANDMARK_STRIDE, type LandmarkName } from "../../protocol/module.js";
import { type Brush, disc, stroke } from "./layer.js";
import { ellipseOf } from "./robot.js";

/** In the order of the module. */
const KINDS = ["wall", "corner", "post"] as const satisfies readonly LandmarkName[];
/** Radius of the circle of something seen once, and what ten times as often adds, CSS pixels. */
const LEAST = 3;
const GROWTH = 7;
/** On a small picture of a large map, m. */
const WIDEST = 0.4;
/** Half the side of a corner's square, CSS pixels. */
const HALF = 3;

export interface LandmarkShown {
  id: number;
  kind: LandmarkName;
  x: number;
  y: number;
  confidence: number;
}

/** What the rows say, for figures and tests. */
export function landmarksOf(rows: Float32Array): LandmarkShown[] {
  return Array.from({ length: rows.length / LANDMARK_STRIDE }, (_, i) => {
    const at = (place: number): number => rows[i * LANDMARK_STRIDE + place] ?? NaN;
    return { id: at(LANDMARK.id), kind: KINDS[at(LANDMARK.kind)] ?? "wall", x: at(LANDMARK.x), y: at(LANDMARK.y), confidence: at(LANDMARK.confidence) };
  });
}

/** CSS pixels. Walls are found again hundreds of times: by the number itself they would cover the
    map. */
export function radiusOf(confidence: number): number {
  return LEAST + GROWTH * Math.log10(1 + confidence);
}

export function draw(brush: Brush): void {
  const { context, camera, palette, scene: { landmarks } } = brush;
  const colour = palette.css.landmarks;
  for (let i = 0; i + LANDMARK_STRIDE <= landmarks.length; i += LANDMARK_STRIDE) {
    const at = (place: number): number => landmarks[i + place] ?? NaN;
    const [x, y, kind] = [at(LANDMARK.x), at(LANDMARK.y), KINDS[at(LANDMARK.kind)]];
    const confirmed = at(LANDMARK.confirmed) > 0;
    const radius = Math.min(camera.px(radiusOf(at(LANDMARK.confidence))), WIDEST);
    stroke(brush, { colour, width: 1.8, alpha: confirmed ? 1 : 0.5, dash: confirmed ? [] : [2, 2] }, () => context.arc(x, y, radius, 0, 2 * Math.PI));
    if (kind === "wall") continue;
    const { major, minor, angle } = ellipseOf(at(LANDMARK.varX), at(LANDMARK.covXy), at(LANDMARK.varY));
    stroke(brush, { colour, width: 1, alpha: 0.8 }, () => context.ellipse(x, y, major, minor, angle, 0, 2 * Math.PI));
    context.setLineDash([]);
    context.fillStyle = colour;
    context.globalAlpha = confirmed ? 0.9 : 0.4;
    if (kind === "post") disc(brush, x, y, Math.max(at(LANDMARK.radius), camera.px(HALF)));
    else context.fillRect(x - camera.px(HALF), y - camera.px(HALF), 2 * camera.px(HALF), 2 * camera.px(HALF));
  }
}
