// A recorded log through the same SLAM. It knows no truth, takes no commands, and ends.

import { LINE_STRIDE, TRAIL_STRIDE } from "../protocol.js";
import { type Change, GridFeed, headingSigma3, type MapHandle, type Moment, type Note, mapFiles, Samples, sigma3, Slow, type Source, Trail } from "./source.js";

/** The numbers of a replay as the module hands them over. */
export interface ReplayStatusHandle {
  time: number;
  progress: number;
  scans: number;
  x: number;
  y: number;
  heading: number;
  cov_xx: number;
  cov_xy: number;
  cov_yy: number;
  cov_heading: number;
  odometry_x: number;
  odometry_y: number;
  odometry_heading: number;
  loop_closures: number;
  free(): void;
}

export interface ReplayHandle extends MapHandle {
  /** False when the log is at its end. */
  step(): boolean;
  status(): ReplayStatusHandle;
  summary(): string;
  /** NaN NaN, odometry x y, estimate x y of every few scans, as far as they are known now. */
  trail(): Float32Array;
}

/** The whole trail is fetched this often, wall milliseconds: closing a loop moves all of it. */
const TRAIL_PERIOD = 250;

export class ReplaySource implements Source {
  readonly kind = "replay";
  readonly title: string;
  time = 0;
  scans = 0;
  finished = false;
  #run: ReplayHandle;
  #grid = new GridFeed();
  #samples = new Samples();
  #trailAt = -Infinity;
  #notes: Note[] = [];
  #closures = 0;
  #cancelled = false;
  #knownArea: Slow;
  #half: Float64Array;
  #features = 0;
  #distance = 0;
  #wheels: [number, number] | null = null;

  constructor(run: ReplayHandle, name: string) {
    this.#run = run;
    this.title = name;
    this.#half = run.half_size();
    this.#knownArea = new Slow(() => run.known_area());
    this.#notes.push({ time: 0, level: "info", text: `Opened ${name}: ${run.summary()}` });
  }

  step(): void {
    if (this.finished) return;
    const begin = performance.now();
    const more = this.#run.step();
    const millis = performance.now() - begin;
    const s = this.#run.status();
    this.time = s.time;
    this.scans = s.scans;
    if (this.#wheels) this.#distance += Math.hypot(s.odometry_x - this.#wheels[0], s.odometry_y - this.#wheels[1]);
    this.#wheels = [s.odometry_x, s.odometry_y];
    this.#samples.add({
      time: s.time,
      positionError: NaN,
      positionSigma3: sigma3(s.cov_xx, s.cov_xy, s.cov_yy),
      headingError: NaN,
      headingSigma3: headingSigma3(s.cov_heading),
      scanMillis: millis,
      explored: NaN,
    });
    if (s.loop_closures > this.#closures) {
      this.#closures = s.loop_closures;
      this.#notes.push({ time: s.time, level: "info", text: `Loop closed (${s.loop_closures} so far): the map was bent back into place` });
    }
    s.free();
    if (!more) this.#end(`End of the recording: ${this.scans} scans mapped`, "good");
  }

  /** Ends the run here; the map stays. */
  cancel(): void {
    if (this.finished) return;
    this.#cancelled = true;
    this.#end(`Cancelled after ${this.scans} scans; the map so far stays`, "warn");
  }

  moment(): Moment {
    const s = this.#run.status();
    const [halfLength = 0.2, halfWidth = 0.2] = this.#half;
    const moment: Moment = {
      source: this.kind, time: s.time, scans: s.scans, progress: s.progress,
      mode: "manual", finished: this.finished, reason: this.#reason(), activity: "",
      goalX: NaN, goalY: NaN,
      x: s.x, y: s.y, heading: s.heading,
      covXx: s.cov_xx, covXy: s.cov_xy, covYy: s.cov_yy, covHeading: s.cov_heading,
      truthX: NaN, truthY: NaN, truthHeading: NaN,
      odometryX: s.odometry_x, odometryY: s.odometry_y, odometryHeading: s.odometry_heading,
      positionError: NaN, headingError: NaN, odometryError: NaN,
      explored: NaN, knownArea: this.#knownArea.value, features: this.#features, distance: this.#distance, contacts: NaN,
      halfLength, halfWidth,
    };
    s.free();
    return moment;
  }

  change(): Change {
    const now = performance.now();
    const trail = this.finished || now - this.#trailAt >= TRAIL_PERIOD;
    if (trail) this.#trailAt = now;
    const lines = this.#run.lines();
    this.#features = lines.length / LINE_STRIDE;
    return {
      ...this.#grid.next(this.#run),
      scan: this.#run.scan(),
      lines,
      truth: null,
      movers: null,
      path: null,
      rawPath: null,
      tree: null,
      frontiers: null,
      trail: trail ? thinned(this.#run.trail()) : null,
      trailAnew: trail,
      samples: this.#samples.take(),
    };
  }

  notes(): Note[] {
    return this.#notes.splice(0);
  }

  hash(): string {
    return this.#run.state_hash();
  }

  files(): ReturnType<typeof mapFiles> {
    return mapFiles(this.#run, this.title.replace(/\.[a-z]+$/i, "").replace(/[^\w-]+/g, "-"));
  }

  close(): void {
    this.#run.free();
  }

  #end(text: string, level: Note["level"]): void {
    this.finished = true;
    // The last picture stands for good: it must not show the area of a moment before.
    this.#knownArea.refresh();
    this.#notes.push({ time: this.time, level, text });
  }

  #reason(): string {
    if (!this.finished) return "";
    return this.#cancelled ? "cancelled" : "end of the recording";
  }
}

/** One point for every few centimetres: a robot that stands still for an hour leaves one. */
function thinned(points: Float32Array): Float32Array | null {
  const trail = new Trail();
  for (let i = 0; i + TRAIL_STRIDE <= points.length; i += TRAIL_STRIDE) {
    const [truthX = NaN, truthY = NaN, odometryX = NaN, odometryY = NaN, x = NaN, y = NaN] = points.subarray(i, i + TRAIL_STRIDE);
    trail.add([truthX, truthY, odometryX, odometryY, x, y]);
  }
  return trail.take();
}
