// What a run changed since the frame before: long arrays are sent only if they are new.

import { degrees } from "../angle.js";
import type { Change, Renumbering, SubmapsChange } from "../protocol/frame.js";
import { LINE, LINE_STRIDE, type RunStatus, TRAIL_STRIDE, TWIN, TWIN_STRIDE, type WebRun } from "../protocol/module.js";
import { Samples, Trail } from "./feeds.js";

const EMPTY = new Float32Array(0);

type Compared = "hypotheses" | "particles" | "path" | "rawPath" | "tree" | "frontiers" | "doors" | "edits" | "tracks" | "takenOut" | "landmarks" | "refinding";

/** Interval for fetching the plan, wall milliseconds: trees are long and rarely change. */
const PLAN_PERIOD = 120;
/** Interval for fetching what a loop closure moves, wall milliseconds: submaps, and the whole trail
    of a recording. */
const MAP_PERIOD = 250;

export class Changes {
  readonly samples = new Samples();
  #features = 0;
  #grid = { generation: 0, revision: 0 };
  #scansSent = -1;
  #reportsSent = -1;
  #wholeSent = false;
  #planAt = -Infinity;
  #sent: Record<Compared, Float32Array> = { hypotheses: EMPTY, particles: EMPTY, path: EMPTY, rawPath: EMPTY, tree: EMPTY, frontiers: EMPTY, doors: EMPTY, edits: EMPTY, tracks: EMPTY, takenOut: EMPTY, landmarks: EMPTY, refinding: EMPTY };
  #trail = new Trail();
  #mapAt = -Infinity;
  #submaps = { version: -1, known: 0 };
  #renumbered: readonly Renumbering[] = [];
  #twin = { sent: 0, reset: false };

  /** With `bends` the module gives the whole trail, rather than pose by pose. */
  constructor(private readonly module: WebRun, private readonly bends: boolean) {}

  /** Number of walls of the line map, as of the last change. */
  get features(): number {
    return this.#features;
  }

  /** Fetches the plan with the next change. */
  refresh(): void {
    this.#planAt = -Infinity;
  }

  /** A submap was removed or put back: all of them are sent with the next change. */
  renumber(renumbering: Renumbering): void {
    this.#renumbered = [...this.#renumbered, renumbering];
    this.#submaps = { version: -1, known: 0 };
    this.#mapAt = -Infinity;
  }

  /** Another twin begins. */
  twinReset(): void {
    this.#twin = { sent: 0, reset: true };
  }

  follow(s: RunStatus): void {
    if (!this.bends) this.#trail.add([s.truthX, s.truthY, s.odometryX, s.odometryY, s.x, s.y, s.submap, s.time]);
  }

  /** `version` grows with whatever may change scan and lines; `isLast`: the run has ended. */
  take(version: number, isLast: boolean): Change {
    const { module } = this;
    const { generation } = this.#grid;
    const view = module.view(generation, this.#grid.revision);
    this.#grid = { generation: view.generation, revision: view.revision };
    const scanned = version !== this.#scansSent;
    this.#scansSent = version;
    const lines = scanned ? view.lines : null;
    if (lines) this.#features = countWalls(lines);
    const whole = !this.#wholeSent;
    this.#wholeSent = true;
    const now = performance.now();
    const plan = now - this.#planAt >= PLAN_PERIOD;
    if (plan) this.#planAt = now;
    const reports = module.cycle_count();
    const reported = reports !== this.#reportsSent;
    this.#reportsSent = reports;
    return {
      grid: view.grid,
      gridReset: view.generation !== generation,
      scan: scanned ? view.scan : null,
      beams: scanned ? view.beams : null,
      found: scanned ? view.found : null,
      lines,
      cycle: reported ? module.cycle() : null,
      inCycle: module.in_cycle(),
      priorMap: whole ? module.prior_map_walls() : null,
      truth: whole ? module.truth() : null,
      materials: whole ? module.materials() : null,
      // Doors move on their own schedule too, so they are compared rather than tracked.
      doors: this.#fresh("doors", module.doors()),
      hypotheses: scanned ? this.#fresh("hypotheses", module.hypotheses()) : null,
      particles: scanned ? this.#fresh("particles", module.particles()) : null,
      landmarks: scanned ? this.#fresh("landmarks", module.landmarks()) : null,
      refinding: scanned ? this.#fresh("refinding", module.refinding()) : null,
      tracks: scanned ? this.#fresh("tracks", module.tracks()) : null,
      takenOut: scanned ? this.#fresh("takenOut", module.taken_out()) : null,
      movers: module.movers(),
      path: this.#fresh("path", module.path()),
      rawPath: plan ? this.#fresh("rawPath", module.raw_path()) : null,
      tree: plan ? this.#fresh("tree", module.tree()) : null,
      frontiers: plan ? this.#fresh("frontiers", module.frontiers()) : null,
      edits: this.#fresh("edits", module.edits()),
      ...this.#mapChange(now, isLast),
      ...this.#twinChange(),
      samples: this.samples.take(),
    };
  }

  /** An array if it differs from what the page has; otherwise null. */
  #fresh(name: Compared, now: Float32Array): Float32Array | null {
    const before = this.#sent[name];
    if (before.length === now.length && before.every((number, i) => number === now[i])) return null;
    // Sending transfers the array, so a copy is kept.
    this.#sent[name] = now.slice();
    return now;
  }

  #mapChange(now: number, isLast: boolean): Pick<Change, "submaps" | "trail" | "trailReset"> {
    const due = isLast || now - this.#mapAt >= MAP_PERIOD;
    if (due) this.#mapAt = now;
    const submaps = due ? this.#takeSubmaps() : null;
    if (!this.bends) return { submaps, trail: this.#trail.take(), trailReset: false };
    return { submaps, trail: due ? thinned(this.module.trail()) : null, trailReset: due };
  }

  #takeSubmaps(): SubmapsChange | null {
    const { version, known } = this.#submaps;
    const submaps = this.module.submaps(version, known);
    if (!submaps) return null;
    this.#submaps = { version: submaps.version, known: known + submaps.lengths.length };
    const renumbered = this.#renumbered;
    this.#renumbered = [];
    return { ...submaps, renumbered };
  }

  #twinChange(): Pick<Change, "twin" | "twinReset"> {
    const { sent, reset } = this.#twin;
    const samples = this.module.twin_since(sent);
    this.#twin = { sent: sent + samples.length / TWIN_STRIDE, reset: false };
    for (let i = 0; i < samples.length; i += TWIN_STRIDE) {
      samples[i + TWIN.headingOff] = degrees(Math.abs(samples[i + TWIN.headingOff] ?? NaN));
      samples[i + TWIN.headingSigma3] = degrees(samples[i + TWIN.headingSigma3] ?? NaN);
    }
    return { twin: samples.length > 0 ? samples : null, twinReset: reset };
  }
}

function countWalls(lines: Float64Array): number {
  let count = 0;
  for (let i: number = LINE.confirmed; i < lines.length; i += LINE_STRIDE) count += lines[i] ? 1 : 0;
  return count;
}

/** One point every few centimetres: a robot that stands still for an hour leaves one. */
function thinned(points: Float32Array): Float32Array | null {
  const trail = new Trail();
  for (let i = 0; i + TRAIL_STRIDE <= points.length; i += TRAIL_STRIDE) {
    trail.add([...points.subarray(i, i + TRAIL_STRIDE)]);
  }
  return trail.take();
}
