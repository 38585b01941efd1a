// The things at a place of the map: the one answer to "what did they point at?", for the read-out
// under the pointer, for a click and for the inspector.

import { clickSends } from "../errand.js";
import { BEAM, BEAM_STRIDE, DOOR, DOOR_STRIDE, EDIT, EDIT_STRIDE, HYPOTHESIS, HYPOTHESIS_STRIDE, LANDMARK, LANDMARK_STRIDE, LINE, LINE_STRIDE, type Rooms, type Tear, TRACK, TRACK_STRIDE } from "../protocol/module.js";
import { isTouched } from "../screen.js";
import type { Store } from "../store.js";
import { type ClosureName, closureAt } from "./layers/closures.js";
import { joinAt } from "./layers/graph.js";
import { nearestSegment } from "./layers/layer.js";
import { MARK, tearAt } from "./layers/torn.js";
import type { Scene } from "./scene.js";

/** Something that can be pointed at, with what identifies it for as long as it exists. Places are
    in the map frame, m. */
export type Thing =
  | { readonly kind: "torn"; readonly tear: Tear }
  | { readonly kind: "closure"; readonly name: ClosureName }
  /** Given by its later submap. */
  | { readonly kind: "join"; readonly submap: number }
  | { readonly kind: "robot" }
  | { readonly kind: "track" | "point" | "line"; readonly id: number }
  /** One of the places where the robot may be. */
  | { readonly kind: "hypothesis"; readonly x: number; readonly y: number }
  | { readonly kind: "particles" }
  /** A beam of the last scan, given by its index. */
  | { readonly kind: "beam"; readonly number: number }
  /** A door of the simulated world, given by its number. */
  | { readonly kind: "door"; readonly number: number }
  /** A door that was found in the map, given by its posts: x1 y1 x2 y2. */
  | { readonly kind: "doorway"; readonly posts: readonly number[] }
  /** The room or corridor that contains a place. */
  | { readonly kind: "room"; readonly x: number; readonly y: number }
  /** A person's edit, given by its number. */
  | { readonly kind: "edit"; readonly number: number }
  | { readonly kind: "frontier" | "cell"; readonly x: number; readonly y: number }
  | { readonly kind: "submap"; readonly number: number }
  /** A wall of the simulated world, given by its row. */
  | { readonly kind: "truth"; readonly row: number };

/** Pixels within which something is found: more for touch than for a pointer, and most for keyboard
    users, who have only the cross. */
export const REACH = isTouched() ? 18 : 9;
export const KEY_REACH = 40;
/** The same for what a click acts on, and for a beam's end: they lie on other things. */
const ACTS = 10;
/** Pixels within which a click that would send the robot applies to a line instead: the map is full
    of lines, whose normal reach is wider than what is seen. */
const LINE_REACH = 3;
const BEAM_REACH = 8;

/** What is being looked at, and the size of a pixel, m. */
export interface Sight {
  readonly store: Store;
  readonly scene: Scene;
  px(pixels: number): number;
}

/** The mark at a place that a click always chooses: a torn place, a loop closure, or a join of the
    pose graph. None while a goal or a plan is being chosen. */
export function markAt({ store, scene, px }: Sight, x: number, y: number, reach = REACH): Thing | null {
  const { layers, aiming, comparesPaths, quality } = store;
  if (aiming || comparesPaths) return null;
  // Marks lie over everything else.
  const tear = layers.torn ? tearAt(quality?.tears ?? [], x, y, px(Math.max(MARK, reach))) : null;
  if (tear) return { kind: "torn", tear };
  const name = layers.closures ? closureAt(scene.submaps, x, y, px(reach)) : null;
  if (name) return { kind: "closure", name };
  const submap = layers.graph ? joinAt(scene.submaps, x, y, px(reach)) : null;
  return submap === null ? null : { kind: "join", submap };
}

/** What a click at a place acts on: each only if it is shown and no other choice is being made. */
export interface Target {
  readonly mark: Thing | null;
  /** Number of a wall of the line map, while the filter's tab is open. */
  readonly wall: number | null;
  /** Number of a door of the world. */
  readonly door: number | null;
  /** Index of a region among the rooms. */
  readonly room: number | null;
}

export function targetAt(sight: Sight, x: number, y: number): Target {
  const { store: { layers, aiming, tab, comparesPaths, rooms }, scene, px } = sight;
  return {
    mark: markAt(sight, x, y, clickSends(sight.store) === "goes" ? LINE_REACH : REACH),
    wall: tab === "filter" ? wallAt(scene.lines, x, y, px(ACTS)) : null,
    door: layers.truth && !aiming && !comparesPaths ? doorAt(scene.doors, x, y, px(ACTS)) : null,
    room: rooms && layers.rooms && !aiming ? roomAt(rooms, x, y) : null,
  };
}

/** Whether a door of the world is open, or is about to be. */
export function isDoorOpen({ doors }: Scene, door: number): boolean {
  return doors[door * DOOR_STRIDE + DOOR.ordered] === 1;
}

/** The reading of the hit at a place, while the scan is shown. */
export function hitAt({ store: { layers }, scene: { scan, beams }, px }: Sight, x: number, y: number): Reading | null {
  return layers.scan ? readingAt(scan, beams, x, y, px(BEAM_REACH)) : null;
}

/** Everything drawn at a place, the topmost first; the cell of the grid is always included. */
export function thingsAt(sight: Sight, x: number, y: number, reach = REACH): Thing[] {
  const { store: { layers, rooms }, scene, px } = sight;
  const { status, tracks, landmarks, hypotheses, particles, frontiers, lines, truth, submaps, doors, edits } = scene;
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
  const edit = nearestSegment(edits, EDIT_STRIDE, EDIT.x1, x, y, near);
  if (edit !== null) found.push({ kind: "edit", number: edits[edit + EDIT.number] ?? NaN });
  const hit = hitAt(sight, x, y);
  if (hit) found.push({ kind: "beam", number: hit.number });
  const doorway = layers.rooms ? rooms?.doors.find(({ posts }) => nearestSegment(Float32Array.from(posts), 4, 0, x, y, near) !== null) : undefined;
  if (doorway) found.push({ kind: "doorway", posts: doorway.posts });
  const door = layers.truth ? doorAt(doors, x, y, near) : null;
  if (door !== null) found.push({ kind: "door", number: door });
  if (layers.frontiers) {
    const row = nearest(frontiers, 2, 0, x, y, Math.min(near, 0.2));
    if (row !== null) found.push({ kind: "frontier", x: frontiers[row] ?? NaN, y: frontiers[row + 1] ?? NaN });
  }
  if (layers.submaps || layers.graph) {
    const number = Array.from({ length: submaps.count }, (_, i) => i).find((i) => Math.hypot(submaps.shown(i)[0] - x, submaps.shown(i)[1] - y) < near);
    if (number !== undefined) found.push({ kind: "submap", number });
  }
  found.push({ kind: "cell", x, y });
  if (layers.rooms && rooms && roomAt(rooms, x, y) !== null) found.push({ kind: "room", x, y });
  const row = layers.truth ? nearestSegment(truth, 4, 0, x, y, near) : null;
  if (row !== null) found.push({ kind: "truth", row: row / 4 });
  return found.filter((thing) => thing !== null);
}

function named(kind: "track" | "point", rows: Float32Array, stride: number, place: number, row: number | null): Thing | null {
  return row === null || row + stride > rows.length ? null : { kind, id: rows[row + place] ?? NaN };
}

/** The row whose point (x y, starting at its `place`) is nearest, within `reach`, m: where it
    begins. */
function nearest(rows: Float32Array, stride: number, place: number, x: number, y: number, reach: number, counts = (_: number): boolean => true): number | null {
  let [least, found] = [reach, null as number | null];
  for (let row = 0; row + stride <= rows.length; row += stride) {
    const distance = Math.hypot((rows[row + place] ?? NaN) - x, (rows[row + place + 1] ?? NaN) - y);
    if (distance < least && counts(row)) [least, found] = [distance, row];
  }
  return found;
}

/** A hit of the last scan as measured: range and σ in m, and the strength of the echo in the
    sensor's own unit, NaN if it reports none. */
export interface Reading {
  range: number;
  sigma: number;
  quality: number;
  /** Index of its beam in the scan. */
  number: number;
}

/** The reading whose hit is nearest to a map point, within `reach`, m. */
export function readingAt(scan: Float32Array, beams: Float32Array, x: number, y: number, reach: number): Reading | null {
  let [nearest, found] = [reach, -1];
  for (let i = 0; i + 1 < scan.length; i += 2) {
    const distance = Math.hypot((scan[i] ?? NaN) - x, (scan[i + 1] ?? NaN) - y);
    if (distance < nearest) [nearest, found] = [distance, (i / 2) * BEAM_STRIDE];
  }
  if (found < 0) return null;
  const at = (place: number): number => beams[found + place] ?? NaN;
  return { range: at(BEAM.range), sigma: at(BEAM.sigma), quality: at(BEAM.quality), number: at(BEAM.number) };
}

/** The wall whose observed part is nearest to a map point, within `reach`, m. */
export function wallAt(lines: Float64Array, x: number, y: number, reach: number): number | null {
  const row = nearestSegment(lines, LINE_STRIDE, LINE.x1, x, y, reach);
  return row === null ? null : (lines[row + LINE.id] ?? null);
}

/** The number of the door whose leaf is nearest to a map point, within `reach`, m. */
export function doorAt(doors: Float32Array, x: number, y: number, reach: number): number | null {
  const row = nearestSegment(doors, DOOR_STRIDE, DOOR.x1, x, y, reach);
  return row === null ? null : row / DOOR_STRIDE;
}

/** The region that contains a map point; null outside of all. */
export function roomAt({ regions }: Pick<Rooms, "regions">, x: number, y: number): number | null {
  const room = regions.findIndex(({ outlines }) => outlines.reduce((count, ring) => count + crossings(ring, x, y), 0) % 2 === 1);
  return room < 0 ? null : room;
}

/** How often a ray to the right crosses an outline. */
function crossings(ring: Float32Array, x: number, y: number): number {
  let count = 0;
  let [ax = 0, ay = 0] = ring.slice(-2);
  for (let i = 0; i + 1 < ring.length; i += 2) {
    const [bx = 0, by = 0] = [ring[i], ring[i + 1]];
    if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) count += 1;
    [ax, ay] = [bx, by];
  }
  return count;
}
