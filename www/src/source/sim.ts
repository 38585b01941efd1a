// A simulated run: world, robot, sensors, SLAM and pilot in one deterministic loop of the module.

import type { ModeName, Setup } from "../protocol.js";
import { type Change, GridFeed, type MapHandle, type Moment, type Note, mapFiles, Samples, type Source, Trail } from "./source.js";

/** The numbers of a simulated run as the module hands them over. */
export interface ExperimentStatusHandle {
  time: number;
  scans: number;
  x: number;
  y: number;
  heading: number;
  cov_xx: number;
  cov_xy: number;
  cov_yy: number;
  cov_heading: number;
  truth_x: number;
  truth_y: number;
  truth_heading: number;
  odometry_x: number;
  odometry_y: number;
  odometry_heading: number;
  position_error: number;
  heading_error: number;
  odometry_error: number;
  explored: number;
  known_area: number;
  features: number;
  distance: number;
  contacts: number;
  half_length: number;
  half_width: number;
  goal_x: number;
  goal_y: number;
  finished: boolean;
  free(): void;
}

export interface ExperimentHandle extends MapHandle {
  step(): void;
  status(): ExperimentStatusHandle;
  mode(): string;
  activity(): string;
  reason(): string;
  explore(): void;
  manual(): void;
  go_to(x: number, y: number): void;
  drive(forward: number, turn: number): void;
  stop(): void;
  truth(): Float32Array;
  path(): Float32Array;
  raw_path(): Float32Array;
  tree(): Float32Array;
  frontiers(): Float32Array;
}

/** The plan is fetched this often, wall milliseconds: trees are long and change seldom. */
const PLAN_PERIOD = 120;

export class SimSource implements Source {
  readonly kind = "sim";
  readonly title: string;
  readonly sliceMillis = 12;
  time = 0;
  scans = 0;
  finished = false;
  #run: ExperimentHandle;
  #grid = new GridFeed();
  #samples = new Samples();
  #trail = new Trail();
  #planAt = -Infinity;
  #activity = "";
  #wasFinished = false;
  #contacts = 0;

  constructor(run: ExperimentHandle, setup: Setup) {
    this.#run = run;
    this.title = setup.world;
    this.#look(0);
  }

  step(): void {
    const begin = performance.now();
    this.#run.step();
    this.#look(performance.now() - begin);
  }

  explore(): void {
    this.#run.explore();
    this.#planAt = -Infinity;
  }

  manual(): void {
    this.#run.manual();
  }

  goTo(x: number, y: number): void {
    this.#run.go_to(x, y);
    this.#planAt = -Infinity;
  }

  drive(forward: number, turn: number): void {
    this.#run.drive(forward, turn);
  }

  stop(): void {
    this.#run.stop();
    this.#planAt = -Infinity;
  }

  moment(): Moment {
    const s = this.#run.status();
    const moment: Moment = {
      source: this.kind, time: s.time, scans: s.scans, progress: NaN,
      mode: this.#run.mode() as ModeName, finished: s.finished, reason: this.#run.reason(), activity: this.#run.activity(),
      goalX: s.goal_x, goalY: s.goal_y,
      x: s.x, y: s.y, heading: s.heading,
      covXx: s.cov_xx, covXy: s.cov_xy, covYy: s.cov_yy, covHeading: s.cov_heading,
      truthX: s.truth_x, truthY: s.truth_y, truthHeading: s.truth_heading,
      odometryX: s.odometry_x, odometryY: s.odometry_y, odometryHeading: s.odometry_heading,
      positionError: s.position_error, headingError: s.heading_error, odometryError: s.odometry_error,
      explored: s.explored, knownArea: s.known_area, features: s.features, distance: s.distance, contacts: s.contacts,
      halfLength: s.half_length, halfWidth: s.half_width,
    };
    s.free();
    return moment;
  }

  change(): Change {
    const now = performance.now();
    const plan = now - this.#planAt >= PLAN_PERIOD;
    if (plan) this.#planAt = now;
    return {
      grid: this.#grid.next(this.#run),
      scan: this.#run.scan(),
      lines: this.#run.lines(),
      truth: this.#run.truth(),
      path: this.#run.path(),
      rawPath: plan ? this.#run.raw_path() : null,
      tree: plan ? this.#run.tree() : null,
      frontiers: plan ? this.#run.frontiers() : null,
      trail: this.#trail.take(),
      trailAnew: false,
      samples: this.#samples.take(),
    };
  }

  notes(): Note[] {
    const notes: Note[] = [];
    const activity = this.#run.activity();
    if (activity !== this.#activity && activity !== "") notes.push({ time: this.time, level: "info", text: activity });
    this.#activity = activity;
    if (this.finished && !this.#wasFinished) notes.push({ time: this.time, level: "good", text: this.#run.reason() });
    this.#wasFinished = this.finished;
    return notes;
  }

  hash(): string {
    return this.#run.state_hash();
  }

  files(): ReturnType<typeof mapFiles> {
    return mapFiles(this.#run, this.title.replace(/[^\w-]+/g, "-"));
  }

  close(): void {
    this.#run.free();
  }

  /** Keeps what plots and trails need of the step just made. */
  #look(millis: number): void {
    const s = this.#run.status();
    this.time = s.time;
    this.finished = s.finished;
    this.#trail.add([s.truth_x, s.truth_y, s.odometry_x, s.odometry_y, s.x, s.y]);
    this.#contacts = Math.max(this.#contacts, s.contacts);
    if (s.scans > this.scans) {
      this.scans = s.scans;
      this.#samples.add({
        time: s.time,
        positionError: s.position_error,
        positionSigma3: 3 * Math.sqrt(Math.max(0, s.cov_xx + s.cov_yy)),
        headingError: (Math.abs(s.heading_error) * 180) / Math.PI,
        headingSigma3: (3 * Math.sqrt(Math.max(0, s.cov_heading)) * 180) / Math.PI,
        scanMillis: millis,
        explored: s.explored,
      });
    }
    s.free();
  }
}
