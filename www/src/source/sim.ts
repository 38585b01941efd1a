// A simulated run: world, robot, sensors, SLAM and pilot in one deterministic loop of the module.

import { LINE_STRIDE, type ModeName, type Setup } from "../protocol.js";
import { errand } from "./errand.js";
import { type Change, GridFeed, headingSigma3, type MapHandle, type Moment, type Note, mapFiles, Samples, sigma3, Slow, type Source, Trail } from "./source.js";

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
  distance: number;
  contacts: number;
  goal_x: number;
  goal_y: number;
  finished: boolean;
  free(): void;
}

export interface ExperimentHandle extends MapHandle {
  decide(): void;
  advance(): void;
  status(): ExperimentStatusHandle;
  mode(): string;
  activity(): string;
  planner(): string;
  explored(): number;
  explore(): void;
  manual(): void;
  go_to(x: number, y: number): void;
  drive(forward: number, turn: number): void;
  stop(): void;
  truth(): Float32Array;
  movers(): Float32Array;
  path(): Float32Array;
  raw_path(): Float32Array;
  tree(): Float32Array;
  frontiers(): Float32Array;
}

const EMPTY = new Float32Array(0);

type PlanPart = "path" | "rawPath" | "tree" | "frontiers";

/** The plan is fetched this often, wall milliseconds: trees are long and change seldom. */
const PLAN_PERIOD = 120;

export class SimSource implements Source {
  readonly kind = "sim";
  readonly title: string;
  time = 0;
  scans = 0;
  finished = false;
  #run: ExperimentHandle;
  #grid = new GridFeed();
  #samples = new Samples();
  #trail = new Trail();
  #explored: Slow;
  #knownArea: Slow;
  #half: Float64Array;
  #features = 0;
  #truthSent = false;
  #planAt = -Infinity;
  #scanSent = -1;
  #sent: Record<PlanPart, Float32Array> = { path: EMPTY, rawPath: EMPTY, tree: EMPTY, frontiers: EMPTY };
  #told = { goal: "", end: "", contacts: 0 };
  #notes: Note[] = [];

  constructor(run: ExperimentHandle, setup: Setup) {
    this.#run = run;
    this.title = setup.world;
    this.#half = run.half_size();
    this.#explored = new Slow(() => run.explored());
    this.#knownArea = new Slow(() => run.known_area());
    this.#look(0);
    const sensor = setup.sensor === "lidar" ? "a lidar" : "four infra-red rangers";
    this.#notes.push({ time: 0, level: "info", text: `A robot with ${sensor} wakes up in ${setup.world}, seed ${setup.seed}` });
  }

  step(): void {
    this.#run.decide();
    // Planning is not counted: the plot tells what a scan costs.
    const begin = performance.now();
    this.#run.advance();
    this.#look(performance.now() - begin);
  }

  explore(): void {
    this.#run.explore();
    this.#commanded();
  }

  manual(): void {
    this.#run.manual();
    this.#commanded();
  }

  goTo(x: number, y: number): void {
    this.#run.go_to(x, y);
    this.#commanded();
  }

  drive(forward: number, turn: number): void {
    this.#run.drive(forward, turn);
    this.#commanded();
  }

  stop(): void {
    this.#run.stop();
    this.#notes.push({ time: this.time, level: "info", text: "Stop" });
    this.#commanded();
  }

  moment(): Moment {
    const s = this.#run.status();
    const mode = this.#run.mode() as ModeName;
    const activity = this.#run.activity();
    const [halfLength = 0.1, halfWidth = 0.1] = this.#half;
    const moment: Moment = {
      source: this.kind, time: s.time, scans: s.scans, progress: NaN,
      mode, finished: s.finished, reason: s.finished ? activity : "",
      activity: s.finished ? "" : errand(mode, activity, s.x, s.y, s.goal_x, s.goal_y),
      goalX: s.goal_x, goalY: s.goal_y,
      x: s.x, y: s.y, heading: s.heading,
      covXx: s.cov_xx, covXy: s.cov_xy, covYy: s.cov_yy, covHeading: s.cov_heading,
      truthX: s.truth_x, truthY: s.truth_y, truthHeading: s.truth_heading,
      odometryX: s.odometry_x, odometryY: s.odometry_y, odometryHeading: s.odometry_heading,
      positionError: Math.hypot(s.x - s.truth_x, s.y - s.truth_y), headingError: turnBetween(s.heading, s.truth_heading),
      odometryError: Math.hypot(s.odometry_x - s.truth_x, s.odometry_y - s.truth_y),
      explored: this.#explored.value, knownArea: this.#knownArea.value, features: this.#features,
      distance: s.distance, contacts: s.contacts, halfLength, halfWidth,
    };
    s.free();
    return moment;
  }

  change(): Change {
    const now = performance.now();
    const plan = now - this.#planAt >= PLAN_PERIOD;
    if (plan) this.#planAt = now;
    const truth = this.#truthSent ? null : this.#run.truth();
    this.#truthSent = true;
    const scanned = this.#scanSent !== this.scans;
    this.#scanSent = this.scans;
    const lines = scanned ? this.#run.lines() : null;
    if (lines) this.#features = countWalls(lines);
    return {
      ...this.#grid.next(this.#run),
      scan: scanned ? this.#run.scan() : null,
      lines,
      truth,
      movers: this.#run.movers(),
      path: this.#fresh("path", this.#run.path()),
      rawPath: plan ? this.#fresh("rawPath", this.#run.raw_path()) : null,
      tree: plan ? this.#fresh("tree", this.#run.tree()) : null,
      frontiers: plan ? this.#fresh("frontiers", this.#run.frontiers()) : null,
      trail: this.#trail.take(),
      trailAnew: false,
      samples: this.#samples.take(),
    };
  }

  /** What differs from what the page has; null where it is the same. */
  #fresh(name: PlanPart, now: Float32Array): Float32Array | null {
    const before = this.#sent[name];
    if (before.length === now.length && now.every((number, i) => number === before[i])) return null;
    // The page takes over what it is sent, so a copy stays.
    this.#sent[name] = now.slice();
    return now;
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

  /** After a command: what it changed is shown and told at once, and a run that had ended is alive again. */
  #commanded(): void {
    this.#planAt = -Infinity;
    this.#look(0);
  }

  /** Keeps what plots, trails and log need of the step just made. */
  #look(millis: number): void {
    const s = this.#run.status();
    this.time = s.time;
    this.finished = s.finished;
    this.#trail.add([s.truth_x, s.truth_y, s.odometry_x, s.odometry_y, s.x, s.y]);
    if (s.scans > this.scans) {
      this.scans = s.scans;
      this.#samples.add({
        time: s.time,
        positionError: Math.hypot(s.x - s.truth_x, s.y - s.truth_y),
        positionSigma3: sigma3(s.cov_xx, s.cov_xy, s.cov_yy),
        headingError: (Math.abs(turnBetween(s.heading, s.truth_heading)) * 180) / Math.PI,
        headingSigma3: headingSigma3(s.cov_heading),
        scanMillis: millis,
        explored: this.#explored.value,
      });
    }
    this.#tell(s);
    s.free();
  }

  #tell(s: ExperimentStatusHandle): void {
    const note = (level: Note["level"], text: string): void => void this.#notes.push({ time: s.time, level, text });
    const goal = Number.isFinite(s.goal_x) ? `(${s.goal_x.toFixed(2)}, ${s.goal_y.toFixed(2)}) m` : "";
    if (goal !== this.#told.goal && goal !== "") {
      const by = this.#run.planner();
      note("info", `Goal ${goal}${by ? `, way found by ${PLANNERS[by] ?? by}` : ""}`);
    }
    const end = s.finished ? this.#run.activity() : "";
    if (end !== this.#told.end && end !== "") {
      this.#explored.refresh();
      this.#knownArea.refresh();
      note(/^(goal|explored)/.test(end) ? "good" : "warn", end.charAt(0).toUpperCase() + end.slice(1));
    }
    if (s.contacts > this.#told.contacts) note("warn", "Touched something");
    this.#told = { goal, end, contacts: s.contacts };
  }
}

const PLANNERS: Readonly<Record<string, string>> = {
  Straight: "a straight line", Rrt: "RRT", RrtConnect: "RRT-Connect", Wavefront: "a wave over the grid",
};

function countWalls(lines: Float64Array): number {
  let count = 0;
  for (let i = LINE_STRIDE - 1; i < lines.length; i += LINE_STRIDE) count += lines[i] ? 1 : 0;
  return count;
}

/** From `b` to `a`, in (-π, π]. */
function turnBetween(a: number, b: number): number {
  return Math.atan2(Math.sin(a - b), Math.cos(a - b));
}
