// Landmarks of the filter or of the submaps, each in a circle that grows with its confidence: how
// often it was found again (Pilch 2016 §3.5.2, fig. 3.13). Corners and posts have their 95 %
// ellipse; a wall has its band, and its circle is at its middle.

import { LANDMARK, LANDMARK_STRIDE, type LandmarkName } from "../../protocol/module.js";
import { isOutside } from "../camera.js";
import type { PathPencil } from "../painter.js";
import { type Brush, stroke } from "./layer.js";
import { ellipseOf } from "./robot.js";

/** In the order of the module. */
const KINDS = ["wall", "corner", "post"] as const satisfies readonly LandmarkName[];
/** Radius of a landmark seen once, and the increase for ten times as often, CSS pixels. */
const LEAST = 3;
const GROWTH = 7;
/** Largest radius on a small view of a large map, m. */
const WIDEST = 0.4;
/** A wall has its band. */
const NO_ELLIPSE = { major: 0, minor: 0, angle: 0 };
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

/** Radius in CSS pixels. Walls are found again hundreds of times: a radius proportional to that
    would cover the map. */
export function radiusOf(confidence: number): number {
  return LEAST + GROWTH * Math.log10(1 + confidence);
}

/** A landmark to be drawn, m. */
interface Mark { readonly kind: LandmarkName; readonly x: number; readonly y: number; readonly ring: number; readonly radius: number; readonly ellipse: ReturnType<typeof ellipseOf> }

/** Draws all that look alike at once: a thousand of them one by one take longer than a picture
    lasts. */
export function draw(brush: Brush): void {
  const { context, camera, palette } = brush;
  const colour = palette.css.landmarks;
  const half = camera.px(HALF);
  for (const confirmed of [false, true]) {
    const marks = marksIn(brush, confirmed);
    if (marks.length === 0) continue;
    const points = marks.filter(({ kind }) => kind !== "wall");
    // What its square hides is not drawn: on a small view of a large map that is most.
    stroke(brush, { colour, width: 1.8, alpha: confirmed ? 1 : 0.5, dash: confirmed ? [] : [2, 2] }, () => {
      for (const { kind, x, y, ring } of marks) if (kind === "wall" || ring > half) addEllipse(context, x, y, ring, ring, 0);
    });
    stroke(brush, { colour, width: 1, alpha: 0.8 }, () => {
      for (const { x, y, ellipse: { major, minor, angle } } of points) if (major > half) addEllipse(context, x, y, major, minor, angle);
    });
    context.fillStyle = colour;
    context.globalAlpha = confirmed ? 0.9 : 0.4;
    context.beginPath();
    for (const { kind, x, y, radius } of points) {
      if (kind === "post") addEllipse(context, x, y, Math.max(radius, half), Math.max(radius, half), 0);
      else context.rect(x - half, y - half, 2 * half, 2 * half);
    }
    context.fill();
  }
}

/** The landmarks in view. */
function marksIn({ camera, scene: { landmarks } }: Brush, confirmed: boolean): Mark[] {
  const view = camera.visible;
  const marks: Mark[] = [];
  for (let i = 0; i + LANDMARK_STRIDE <= landmarks.length; i += LANDMARK_STRIDE) {
    const at = (place: number): number => landmarks[i + place] ?? NaN;
    if (at(LANDMARK.confirmed) > 0 !== confirmed) continue;
    const [x, y, kind] = [at(LANDMARK.x), at(LANDMARK.y), KINDS[at(LANDMARK.kind)] ?? "wall"];
    const ring = Math.min(camera.px(radiusOf(at(LANDMARK.confidence))), WIDEST);
    const ellipse = kind === "wall" ? NO_ELLIPSE : ellipseOf(at(LANDMARK.varX), at(LANDMARK.covXy), at(LANDMARK.varY));
    const reach = Math.max(ring, ellipse.major, at(LANDMARK.radius) || 0) + camera.px(HALF);
    if (!isOutside(view, x, y, x, y, reach)) marks.push({ kind, x, y, ring, radius: at(LANDMARK.radius), ellipse });
  }
  return marks;
}

/** Adds a whole separate ellipse to the path. */
function addEllipse(context: PathPencil, x: number, y: number, major: number, minor: number, angle: number): void {
  context.moveTo(x + major * Math.cos(angle), y + major * Math.sin(angle));
  context.ellipse(x, y, major, minor, angle, 0, 2 * Math.PI);
}
