// A recorded log through the same SLAM. It knows no truth, takes no commands, and ends.

import { type Change, GridFeed, type MapHandle, type Moment, type Note, mapFiles, Samples, type Source } from "./source.js";

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
  known_area: number;
  features: number;
  loop_closures: number;
  distance: number;
  half_length: number;
  half_width: number;
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
  readonly sliceMillis = 24;
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

  constructor(run: ReplayHandle, name: string) {
    this.#run = run;
    this.title = name;
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
    this.#samples.add({
      time: s.time,
      positionError: NaN,
      positionSigma3: 3 * Math.sqrt(Math.max(0, s.cov_xx + s.cov_yy)),
      headingError: NaN,
      headingSigma3: (3 * Math.sqrt(Math.max(0, s.cov_heading)) * 180) / Math.PI,
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
    const moment: Moment = {
      source: this.kind, time: s.time, scans: s.scans, progress: s.progress,
      mode: "manual", finished: this.finished, reason: this.#reason(), activity: "",
      goalX: NaN, goalY: NaN,
      x: s.x, y: s.y, heading: s.heading,
      covXx: s.cov_xx, covXy: s.cov_xy, covYy: s.cov_yy, covHeading: s.cov_heading,
      truthX: NaN, truthY: NaN, truthHeading: NaN,
      odometryX: s.odometry_x, odometryY: s.odometry_y, odometryHeading: s.odometry_heading,
      positionError: NaN, headingError: NaN, odometryError: NaN,
      explored: NaN, knownArea: s.known_area, features: s.features, distance: s.distance, contacts: NaN,
      halfLength: s.half_length, halfWidth: s.half_width,
    };
    s.free();
    return moment;
  }

  change(): Change {
    const now = performance.now();
    const trail = this.finished || now - this.#trailAt >= TRAIL_PERIOD;
    if (trail) this.#trailAt = now;
    return {
      grid: this.#grid.next(this.#run),
      scan: this.#run.scan(),
      lines: this.#run.lines(),
      truth: null,
      path: null,
      rawPath: null,
      tree: null,
      frontiers: null,
      trail: trail ? this.#run.trail() : null,
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
    this.#notes.push({ time: this.time, level, text });
  }

  #reason(): string {
    if (!this.finished) return "";
    return this.#cancelled ? "cancelled" : "end of the recording";
  }
}
