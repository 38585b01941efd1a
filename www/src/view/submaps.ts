// Submaps as they are drawn: when a loop closure moves them they glide, together with everything
// that is attached to them.

import { turnBetween } from "../angle.js";
import type { SubmapsChange } from "../protocol/frame.js";
import { CLOSURE, CLOSURE_STRIDE, type ClosureOutcome, EXTENT, EXTENT_STRIDE, SUBMAP, SUBMAP_STRIDE } from "../protocol/module.js";
import { type Box, union } from "./camera.js";

/** The fate of a placement, as people distinguish it; accepted placements of consecutive submaps
    ("neighbours") close no loop. */
export type Fate = "accepted" | "neighbour" | "waiting" | "refused" | "revoked";
const FATE: Readonly<Record<ClosureOutcome, Exclude<Fate, "neighbour">>> = {
  "known-before": "accepted", proved: "accepted", "not-judged": "waiting", "too-little-proof": "waiting", "beyond-belief": "waiting", rivals: "waiting",
  tears: "waiting", overruled: "waiting", "placed-elsewhere": "refused", "never-proved": "refused", revoked: "revoked",
};

/** Duration of a glide, wall milliseconds. */
const GLIDE_MILLIS = 600;
/** The grid is redrawn in the background. Until then walls are drawn at their new places, but no
    longer than this, wall milliseconds. */
const REDRAW_MILLIS = 3000;
/** How long newly accepted closures stand out, wall milliseconds. */
const FRESH_MILLIS = 2500;
/** A smaller motion is not reported, m. */
export const LEAST_MOVE = 0.05;

const EMPTY = new Float32Array(0);

/** x y heading. */
type Place = readonly [number, number, number];
/** A rotation and translation: x' = cos x - sin y + dx, y' = sin x + cos y + dy. */
export interface Shift { readonly cos: number; readonly sin: number; readonly dx: number; readonly dy: number }

export class Submaps {
  /** See SUBMAP: the latest poses, and those from which they glide. */
  #poses: Float32Array = EMPTY;
  #from: Float32Array = EMPTY;
  #began = -Infinity;
  #part = 1;
  #awaitsGrid = false;
  /** x y of the walls of each submap, in its own frame. */
  readonly surfaces: Float32Array[] = [];
  /** See EXTENT, for complete submaps. */
  #extents: readonly number[] = [];
  /** This many submaps, the first ones, can be removed. */
  removable = 0;
  /** The submap that was last removed and can be put back. */
  undoable: number | undefined;
  /** Names of the closed loops, of the newest ones, and the time of those. */
  #accepted: ReadonlySet<string> = new Set();
  #news: ReadonlySet<string> = new Set();
  #acceptedAt = -Infinity;
  /** Rows of the newly closed loops, and how much they still stand out, 1 to 0. */
  fresh: { rows: readonly number[]; part: number } = { rows: [], part: 0 };
  /** See CLOSURE. */
  closures: Float32Array = EMPTY;
  outcomes: readonly ClosureOutcome[] = [];
  /** The fate of each closure, row by row. */
  fates: readonly Fate[] = [];

  clear(): void {
    [this.#poses, this.#from, this.closures] = [EMPTY, EMPTY, EMPTY];
    [this.#began, this.#part, this.#awaitsGrid] = [-Infinity, 1, false];
    [this.outcomes, this.fates] = [[], []];
    [this.#accepted, this.#news] = [new Set(), new Set()];
    this.fresh = { rows: [], part: 0 };
    this.surfaces.length = 0;
    this.#extents = [];
    this.removable = 0;
    this.undoable = undefined;
  }

  get count(): number {
    return this.#poses.length / SUBMAP_STRIDE;
  }

  /** Whether submaps are gliding. */
  get glides(): boolean {
    return this.#part < 1;
  }

  /** Whether the grid shows walls at their old places: during a glide, and until it is redrawn. */
  get ahead(): boolean {
    return this.glides || this.#awaitsGrid;
  }

  /** Whether the next picture differs even if nothing else changes. */
  get isLively(): boolean {
    return this.ahead || this.fresh.part > 0;
  }

  /** Takes a change at a wall time. Returns how far it moves existing submaps, m. */
  take({ poses, lengths, surfaces, extents, removable, undoable, closures, outcomes, renumbered }: SubmapsChange, wall: number): number {
    if (renumbered.length > 0) {
      // After renumbering, other submaps have the old names: nothing glides, and no closure is new.
      this.clear();
      this.#accepted = new Set(loopsOf(closures, fatesOf(closures, outcomes)).map(([name]) => name));
    }
    this.#extents = [...this.#extents, ...extents];
    this.removable = removable;
    this.undoable = undoable;
    let at = 0;
    for (const length of lengths) this.surfaces.push(surfaces.subarray(at, (at += length)));
    const before = this.#poses;
    const from = this.#placesOf(poses);
    this.fates = fatesOf(closures, outcomes);
    this.#markFresh(closures, wall);
    [this.#poses, this.closures, this.outcomes] = [poses, closures, outcomes];
    let moved = 0;
    for (let i = 0; i < before.length; i += SUBMAP_STRIDE) {
      moved = Math.max(moved, Math.hypot((poses[i] ?? 0) - (before[i] ?? 0), (poses[i + 1] ?? 0) - (before[i + 1] ?? 0)));
    }
    // A glide that is under way continues from its present place.
    if (moved >= LEAST_MOVE || this.glides) [this.#from, this.#began, this.#part] = [from, wall, 0];
    this.#awaitsGrid ||= moved >= LEAST_MOVE;
    return moved;
  }

  /** Where all submaps are drawn now; new ones move along with the last known one. */
  #placesOf(next: Float32Array): Float32Array {
    const places = Float32Array.from(next);
    const last = this.count - 1;
    if (last < 0) return places;
    const [at, shown] = [placeOf(next, last), this.shown(last)];
    const along = between(at, shown);
    for (let i = 0; i * SUBMAP_STRIDE < next.length; i += 1) {
      const [x, y, heading] = placeOf(next, i);
      places.set(i <= last ? this.shown(i) : [...moved(along, x, y), heading + shown[2] - at[2]], i * SUBMAP_STRIDE);
    }
    return places;
  }

  #markFresh(closures: Float32Array, wall: number): void {
    const accepted = loopsOf(closures, this.fates);
    const news = accepted.map(([name]) => name).filter((name) => !this.#accepted.has(name));
    if (news.length > 0) [this.#acceptedAt, this.#news] = [wall, new Set(news)];
    this.#accepted = new Set(accepted.map(([name]) => name));
    this.fresh = { ...this.fresh, rows: accepted.filter(([name]) => this.#news.has(name)).map(([, row]) => row) };
  }

  /** The grid was redrawn. */
  redrawn(): void {
    this.#awaitsGrid = false;
  }

  /** Moves submaps to their places at a wall time; with `still`, at once. */
  animate(wall: number, still: boolean): void {
    this.fresh = { ...this.fresh, part: still ? 0 : Math.max(0, 1 - (wall - this.#acceptedAt) / FRESH_MILLIS) };
    const passed = wall - this.#began;
    const part = still ? 1 : Math.min(passed / GLIDE_MILLIS, 1);
    this.#part = part * part * (3 - 2 * part);
    if (still || passed > REDRAW_MILLIS) this.#awaitsGrid = false;
  }

  /** The pose at which a submap is drawn now. */
  shown(submap: number): Place {
    const known = placeOf(this.#poses, submap);
    if (!this.glides) return known;
    const from = placeOf(this.#from, submap);
    const mix = (a: number, b: number): number => a + (b - a) * this.#part;
    return [mix(from[0], known[0]), mix(from[1], known[1]), from[2] + turnBetween(known[2], from[2]) * this.#part];
  }

  isLoose(submap: number): boolean {
    return this.#poses[submap * SUBMAP_STRIDE + SUBMAP.loose] === 1;
  }

  /** A figure of a submap, see SUBMAP. */
  figure(submap: number, name: keyof typeof SUBMAP): number {
    return this.#poses[submap * SUBMAP_STRIDE + SUBMAP[name]] ?? NaN;
  }

  /** A figure of a complete submap, see EXTENT; NaN for the one that is being made. */
  extent(submap: number, name: keyof typeof EXTENT): number {
    return this.#extents[submap * EXTENT_STRIDE + EXTENT[name]] ?? NaN;
  }

  /** Its bounding box in the map; null while it has no walls. */
  bounds(submap: number): Box | null {
    return boundsOf(this.surfaces[submap] ?? EMPTY, this.shown(submap));
  }

  keyframes(submap: number): number {
    return this.#poses[submap * SUBMAP_STRIDE + SUBMAP.keyframes] ?? 0;
  }

  /** The motion from a submap's latest pose to where it is drawn, which applies to everything
      attached to it; null if it is zero. */
  shift(submap: number): Shift | null {
    return this.glides && submap < this.count ? between(placeOf(this.#poses, submap), this.shown(submap)) : null;
  }

  /** The motion from its pose in another set of poses to the latest. */
  shiftFrom(before: Float32Array, submap: number): Shift | null {
    if ((submap + 1) * SUBMAP_STRIDE > before.length) return null;
    return between(placeOf(before, submap), placeOf(this.#poses, submap));
  }

  /** The latest poses, see SUBMAP. */
  get poses(): Float32Array {
    return this.#poses;
  }
}

function fatesOf(closures: Float32Array, outcomes: readonly ClosureOutcome[]): Fate[] {
  return outcomes.map((outcome, row) => {
    const fate = FATE[outcome];
    return fate === "accepted" && closures[row * CLOSURE_STRIDE + CLOSURE.loopClosed] !== 1 ? "neighbour" : fate;
  });
}

/** Names and rows of the accepted closures that close a loop. */
function loopsOf(closures: Float32Array, fates: readonly Fate[]): (readonly [string, number])[] {
  return fates.flatMap((fate, row) => (fate === "accepted" ? [[nameOf(closures, row), row] as const] : []));
}

/** A closure is named by its two submaps. */
function nameOf(closures: Float32Array, row: number): string {
  const at = row * CLOSURE_STRIDE;
  return `${closures[at + CLOSURE.old]} ${closures[at + CLOSURE.new]}`;
}

function placeOf(poses: Float32Array, submap: number): Place {
  const at = submap * SUBMAP_STRIDE;
  return [poses[at + SUBMAP.x] ?? NaN, poses[at + SUBMAP.y] ?? NaN, poses[at + SUBMAP.heading] ?? NaN];
}

/** The rigid motion that takes `from` to `to`. */
function between(from: Place, to: Place): Shift {
  const turn = to[2] - from[2];
  const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
  return { cos, sin, dx: to[0] - cos * from[0] + sin * from[1], dy: to[1] - sin * from[0] - cos * from[1] };
}

export function moved({ cos, sin, dx, dy }: Shift, x: number, y: number): [number, number] {
  return [cos * x - sin * y + dx, sin * x + cos * y + dy];
}

/** A point of the frame at pose `place`, in the map frame. */
export function within(place: Place, x: number, y: number): [number, number] {
  const [cos, sin] = [Math.cos(place[2]), Math.sin(place[2])];
  return [place[0] + cos * x - sin * y, place[1] + sin * x + cos * y];
}

/** The bounding box of points in the frame at pose `place`. */
export function boundsOf(points: Float32Array, place: Place): Box | null {
  let box: Box | null = null;
  for (let i = 0; i + 1 < points.length; i += 2) {
    const [x, y] = within(place, points[i] ?? NaN, points[i + 1] ?? NaN);
    box = union(box, { minX: x, minY: y, maxX: x, maxY: y });
  }
  return box;
}
