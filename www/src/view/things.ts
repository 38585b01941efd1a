// What lies at a place of the map: the one answer to "what did they point at?", for the read-out
// under the pointer, for a click and for the inspector.

import { HYPOTHESIS, HYPOTHESIS_STRIDE, LANDMARK, LANDMARK_STRIDE, type Tear, TRACK, TRACK_STRIDE } from "../protocol/module.js";
import type { Store } from "../store.js";
import { type ClosureName, closureAt } from "./layers/closures.js";
import { joinAt } from "./layers/graph.js";
import { nearestSegment } from "./layers/layer.js";
import { wallAt } from "./layers/spot.js";
import { MARK, tearAt } from "./layers/torn.js";
import type { Scene } from "./scene.js";

/** Something that can be pointed at, by what names it for as long as it is there. Places are of the
    map frame, m. */
export type Thing =
  | { readonly kind: "torn"; readonly tear: Tear }
  | { readonly kind: "closure"; readonly name: ClosureName }
  /** By its later submap. */
  | { readonly kind: "join"; readonly submap: number }
  | { readonly kind: "robot" }
  | { readonly kind: "track" | "point" | "line"; readonly id: number }
  /** One of those where the robot may be. */
  | { readonly kind: "hypothesis"; readonly x: number; readonly y: number }
  | { readonly kind: "particles" }
  | { readonly kind: "frontier" | "cell"; readonly x: number; readonly y: number }
  | { readonly kind: "submap"; readonly number: number }
  /** A wall of the simulated world, by its row. */
  | { readonly kind: "truth"; readonly row: number };

/** Pixels within which something is found; a finger is wider than a pointer, and who comes by keys
    has the cross only. */
export const REACH = matchMedia("(pointer: coarse)").matches ? 18 : 9;
export const KEY_REACH = 40;

/** What is looked at, and how long a pixel is there, m. */
export interface Sight {
  readonly store: Store;
  readonly scene: Scene;
  px(pixels: number): number;
}

/** The mark of the map there that a click always chooses: a torn place, a loop closure, or a join
    of the pose graph. Not while a goal or a plan is being chosen. */
export function markAt({ store, scene, px }: Sight, x: number, y: number, reach = REACH): Thing | null {
  const { layers, aiming, tab, quality } = store;
  if (aiming || tab === "paths") return null;
  // Marks lie over all else.
  const tear = layers.torn ? tearAt(quality?.tears ?? [], x, y, px(Math.max(MARK, reach))) : null;
  if (tear) return { kind: "torn", tear };
  const name = layers.closures ? closureAt(scene.submaps, x, y, px(reach)) : null;
  if (name) return { kind: "closure", name };
  const submap = layers.graph ? joinAt(scene.submaps, x, y, px(reach)) : null;
  return submap === null ? null : { kind: "join", submap };
}

/** All that is drawn there, what lies on top first; the cell of the grid is there always. */
export function thingsAt(sight: Sight, x: number, y: number, reach = REACH): Thing[] {
  const { store: { layers }, scene, px } = sight;
  const { status, tracks, landmarks, hypotheses, particles, frontiers, lines, truth, submaps } = scene;
  const found: (Thing | null)[] = [markAt(sight, x, y, reach)];
  const near = px(reach);
  if (layers.robot && status && Math.hypot(status.x - x, status.y - y) < Math.max(near, status.halfLength, px(9))) found.push({ kind: "robot" });
  if (layers.tracks) found.push(named("track", tracks, TRACK_STRIDE, TRACK.id, nearest(tracks, TRACK_STRIDE, TRACK.x, x, y, Math.max(near, 0.3))));
  if (layers.hypotheses) {
    const row = nearest(hypotheses, HYPOTHESIS_STRIDE, HYPOTHESIS.x, x, y, px(reach + 4));
    if (row !== null) found.push({ kind: "hypothesis", x: hypotheses[row + HYPOTHESIS.x] ?? NaN, y: hypotheses[row + HYPOTHESIS.y] ?? NaN });
    if (nearest(particles, 2, 0, x, y, near) !== null) found.push({ kind: "particles" });
  }
  if (layers.landmarks || layers.points) {
    const row = nearest(landmarks, LANDMARK_STRIDE, LANDMARK.x, x, y, near, (at) => (landmarks[at + LANDMARK.kind] ?? 0) > 0);
    found.push(named("point", landmarks, LANDMARK_STRIDE, LANDMARK.id, row));
  }
  const wall = layers.lines || layers.walls ? wallAt(lines, x, y, near) : null;
  if (wall !== null) found.push({ kind: "line", id: wall });
  if (layers.frontiers) {
    const row = nearest(frontiers, 2, 0, x, y, Math.min(near, 0.2));
    if (row !== null) found.push({ kind: "frontier", x: frontiers[row] ?? NaN, y: frontiers[row + 1] ?? NaN });
  }
  if (layers.submaps || layers.graph) {
    const number = Array.from({ length: submaps.count }, (_, i) => i).find((i) => Math.hypot(submaps.shown(i)[0] - x, submaps.shown(i)[1] - y) < near);
    if (number !== undefined) found.push({ kind: "submap", number });
  }
  found.push({ kind: "cell", x, y });
  const row = layers.truth ? nearestSegment(truth, 4, 0, x, y, near) : null;
  if (row !== null) found.push({ kind: "truth", row: row / 4 });
  return found.filter((thing) => thing !== null);
}

function named(kind: "track" | "point", rows: Float32Array, stride: number, place: number, row: number | null): Thing | null {
  return row === null || row + stride > rows.length ? null : { kind, id: rows[row + place] ?? NaN };
}

/** Where the row begins whose point, x y from its `place` on, is nearest, if it is nearer than
    `reach`, m. */
function nearest(rows: Float32Array, stride: number, place: number, x: number, y: number, reach: number, counts = (_: number): boolean => true): number | null {
  let [least, found] = [reach, null as number | null];
  for (let row = 0; row + stride <= rows.length; row += stride) {
    const distance = Math.hypot((rows[row + place] ?? NaN) - x, (rows[row + place + 1] ?? NaN) - y);
    if (distance < least && counts(row)) [least, found] = [distance, row];
  }
  return found;
}
