// Everything to be drawn: the latest data of all kinds, taken from frames as they come.

import { type Frame, type Status, type SubmapsChange } from "../protocol/frame.js";
import { type FieldName, TRAIL, TRAIL_STRIDE } from "../protocol/module.js";
import { type Box, union } from "./camera.js";
import { Motion } from "./motion.js";
import { moved, Submaps } from "./submaps.js";
import { Tiles } from "./tiles.js";

/** From the bottom up, by default. */
export const LAYERS = ["grid", "wheels", "truth", "submaps", "compared", "trails", "graph", "closures", "rooms", "priorMap", "hypotheses", "frontiers", "lines", "walls", "landmarks", "tree", "scan", "tracks", "found", "points", "rawPath", "path", "twin", "torn", "robot"] as const;
export type LayerName = (typeof LAYERS)[number];

const EMPTY = new Float32Array(0);

/** Arrays that a frame replaces, if it has them. */
const SHAPES = ["scan", "beams", "doors", "found", "points", "landmarks", "refinding", "tracks", "takenOut", "truth", "priorMap", "hypotheses", "particles", "path", "rawPath", "tree", "frontiers", "edits"] as const;

export class Scene {
  readonly tiles = new Tiles();
  /** The field that came last, and the increase per step of a byte. */
  readonly field = { name: null as FieldName | null, step: 0, tiles: new Tiles() };
  /** The map drawn by odometry alone. */
  readonly wheels = new Tiles();
  /** Status and movers at the time of the picture being drawn, see `animate`. */
  status: Status | null = null;
  scan: Float32Array = EMPTY;
  /** Lines found in the scan, x1 y1 x2 y2. */
  found: Float32Array = EMPTY;
  /** Points found in the scan, see POINT. */
  points: Float32Array = EMPTY;
  /** Landmarks with their confidence, see LANDMARK. */
  landmarks: Float32Array = EMPTY;
  /** How often landmarks are found again, see REFINDING. */
  refinding: Float32Array = EMPTY;
  /** Tracks of moving things, see TRACK. */
  tracks: Float32Array = EMPTY;
  /** x y of the hits of the last scan that were taken out of pose and map. */
  takenOut: Float32Array = EMPTY;
  lines: Float64Array = new Float64Array(0);
  truth: Float32Array = EMPTY;
  /** Material of each true wall: 0 opaque, 1 glass, 2 dark. */
  materials: Uint8Array = new Uint8Array(0);
  /** Walls of the prior map, x1 y1 x2 y2. */
  priorMap: Float32Array = EMPTY;
  /** See HYPOTHESIS. */
  hypotheses: Float32Array = EMPTY;
  /** x y of the particles behind the hypotheses. */
  particles: Float32Array = EMPTY;
  movers: Float32Array = EMPTY;
  /** See DOOR. */
  doors: Float32Array = EMPTY;
  /** How each hit of the scan was read, see BEAM. */
  beams: Float32Array = EMPTY;
  path: Float32Array = EMPTY;
  rawPath: Float32Array = EMPTY;
  tree: Float32Array = EMPTY;
  frontiers: Float32Array = EMPTY;
  /** Edits of the map, see EDIT. */
  edits: Float32Array = EMPTY;
  /** Flat points, see TRAIL_STRIDE. */
  trail: Float32Array = EMPTY;
  trailLength = 0;
  /** Samples of the twin, see TWIN. */
  twin: number[] = [];
  readonly submaps = new Submaps();
  #motion = new Motion();
  /** Grows with every frame taken. */
  version = 0;

  clear(): void {
    this.tiles.clear();
    this.wheels.clear();
    this.field.tiles.clear();
    this.field.name = null;
    this.status = null;
    this.#motion.clear();
    this.submaps.clear();
    this.materials = new Uint8Array(0);
    this.movers = EMPTY;
    for (const name of SHAPES) this[name] = EMPTY;
    this.lines = new Float64Array(0);
    this.trailLength = 0;
    this.twin = [];
    this.version += 1;
  }

  #takeField({ name, step, reset, grid }: NonNullable<Frame["field"]>): void {
    if (reset) this.field.tiles.clear();
    Object.assign(this.field, { name, step });
    if (grid) this.field.tiles.take(grid);
  }

  /** Takes a frame that came at a wall time. Returns how far a loop closure moves the map, m. */
  take(frame: Frame, wall: number): number {
    this.#motion.take(frame);
    if (frame.gridReset) {
      this.tiles.clear();
      this.submaps.redrawn();
    }
    if (frame.grid) this.tiles.take(frame.grid);
    if (frame.wheels) this.wheels.take(frame.wheels);
    if (frame.field) this.#takeField(frame.field);
    this.lines = frame.lines ?? this.lines;
    this.materials = frame.materials ?? this.materials;
    for (const name of SHAPES) this[name] = frame[name] ?? this[name];
    const bent = frame.submaps ? this.#bend(frame.submaps, wall) : 0;
    if (frame.trailReset) this.trailLength = 0;
    if (frame.trail) this.#append(frame.trail);
    if (frame.twinReset) this.twin = [];
    if (frame.twin) this.twin.push(...frame.twin);
    this.version += 1;
    return bent;
  }

  /** The trail of a submap moves with it. Recordings send their whole trail anew. */
  #bend(change: SubmapsChange, wall: number): number {
    for (const { submap, by } of change.renumbered) this.#renumber(submap, by);
    const before = change.renumbered.length > 0 ? EMPTY : this.submaps.poses;
    const most = this.submaps.take(change, wall);
    if (most === 0) return 0;
    for (let i = 0; i + TRAIL_STRIDE <= this.trailLength; i += TRAIL_STRIDE) {
      const shift = this.submaps.shiftFrom(before, this.trail[i + TRAIL.submap] ?? 0);
      if (shift) this.trail.set(moved(shift, this.trail[i + TRAIL.x] ?? NaN, this.trail[i + TRAIL.y] ?? NaN), i + TRAIL.x);
    }
    return most;
  }

  /** The trail refers to submaps by number: those behind one that is removed or put back change. */
  #renumber(submap: number, by: number): void {
    for (let i: number = TRAIL.submap; i < this.trailLength; i += TRAIL_STRIDE) {
      const number = this.trail[i] ?? 0;
      if (number > submap) this.trail[i] = number + by;
    }
  }

  /** Moves everything to its place at a wall time, milliseconds since 1970; with `still` the map
      does not glide. */
  animate(wall: number, still: boolean): void {
    this.submaps.animate(wall, still);
    const state = this.#motion.at(wall);
    if (!state) return;
    this.status = state.status;
    this.movers = state.movers;
  }

  /** Everything worth showing when the view is fitted. */
  bounds(withTruth: boolean, withWheels: boolean): Box | null {
    let box = this.tiles.bounds();
    const wheels = withWheels ? this.wheels.bounds() : null;
    if (wheels) box = union(box, wheels);
    const grow = (x: number, y: number): void => {
      if (!Number.isFinite(x) || !Number.isFinite(y)) return;
      box = union(box, { minX: x, minY: y, maxX: x, maxY: y });
    };
    if (withTruth) for (let i = 0; i + 1 < this.truth.length; i += 2) grow(this.truth[i] ?? NaN, this.truth[i + 1] ?? NaN);
    for (let i = 0; i + 1 < this.priorMap.length; i += 2) grow(this.priorMap[i] ?? NaN, this.priorMap[i + 1] ?? NaN);
    for (let i = 0; i + TRAIL_STRIDE <= this.trailLength; i += TRAIL_STRIDE) grow(this.trail[i + TRAIL.x] ?? NaN, this.trail[i + TRAIL.y] ?? NaN);
    return box;
  }

  #append(points: Float32Array): void {
    const needed = this.trailLength + points.length;
    if (needed > this.trail.length) {
      const grown = new Float32Array(Math.max(needed, this.trail.length * 2, 4096));
      grown.set(this.trail.subarray(0, this.trailLength));
      this.trail = grown;
    }
    this.trail.set(points, this.trailLength);
    this.trailLength = needed;
  }
}
