// A simulated run: world, robot, sensors, SLAM and pilot in one deterministic loop of the module.

import type { RunStatus, WebExperiment } from "../../pkg/slamlab_web.js";
import { plannerTitle } from "../planners.js";
import type { BenchResponse, BenchTrial, Cycle, GrowthName, Mode, Setup, SigmaCurve } from "../protocol/module.js";
import { sigmaCurve } from "./convert.js";
import { errand } from "./errand.js";
import { Slow, Trail } from "./feeds.js";
import { Run } from "./run.js";
import type { Change, Moment } from "./source.js";

const EMPTY = new Float32Array(0);

type PlanPart = "path" | "rawPath" | "tree" | "frontiers";

/** The plan is fetched this often, wall milliseconds: trees are long and change seldom. */
const PLAN_PERIOD = 120;

/** Of a world larger than this, m², nobody waits until all that can be reached is counted; the area known is told all the same. */
const MOST_EXTENT = 10_000;

/** Scans of a standing twin from which σ(ρ) is estimated. */
const STANDING_SCANS = 120;

/** Parts of the reachable area worth a line in the log when they become known. */
const MILESTONES = [0.25, 0.5, 0.75, 0.9, 0.95, 0.99];

export class SimSource extends Run<WebExperiment> {
  readonly kind = "sim";
  #trail = new Trail();
  #explored: Slow;
  #truthSent = false;
  #doors = EMPTY;
  #planAt = -Infinity;
  #sent: Record<PlanPart, Float32Array> = { path: EMPTY, rawPath: EMPTY, tree: EMPTY, frontiers: EMPTY };
  #told = { goal: "", end: "", contacts: 0, milestones: 0 };
  /** Reports of the cycle so far, and those that the page has. */
  #reports = 0;
  #reportsSent = -1;
  #beamHalfAngle: number;
  /** Commands so far: the legs of one errand are told in one line. */
  #errands = 0;

  constructor(module: WebExperiment, setup: Setup) {
    super(module, setup.world, setup.method);
    const countable = module.extent() < MOST_EXTENT;
    this.#explored = new Slow(() => (countable ? module.explored() : NaN));
    this.#beamHalfAngle = module.beam_half_angle();
    this.read((s) => this.#look(s, 0));
    this.note("info", `A robot with ${setup.sensor} wakes up in ${setup.world}, seed ${setup.seed}`);
  }

  step(): void {
    this.module.decide();
    // Planning is not counted: the plot tells what a scan costs.
    const begin = performance.now();
    this.module.advance();
    const millis = performance.now() - begin;
    this.read((s) => this.#look(s, millis));
  }

  /** Lines and pose change within a scan that is followed stage by stage. */
  override get version(): number {
    return this.scans + this.#reports;
  }

  setCycle(on: boolean): void {
    this.module.set_cycle(on);
    this.note("info", on ? "Drives by the cycle: scan standing, plan, one turn, one leg, again" : "Drives while it looks round");
    this.#commanded();
  }

  /** Goes on to the end of the next stage of the cycle. */
  nextStage(): void {
    const begin = performance.now();
    const stage = this.module.next_stage();
    const millis = performance.now() - begin;
    this.read((s) => this.#look(s, millis));
    if (stage === "") return;
    const { stages } = this.#cycle();
    this.note("info", `${stage}: ${stages.find((s) => s.name === stage)?.text ?? ""}`);
  }

  configure(keys: string[], values: Float64Array): void {
    this.module.configure(keys, values);
  }

  estimateSigma(growth: GrowthName): SigmaCurve {
    return sigmaCurve(growth, this.module.estimate_sigma(STANDING_SCANS, growth));
  }

  #cycle(): Cycle {
    const flat = this.module.stages();
    const stages = flat.flatMap((name, i) => (i % 2 === 0 ? [{ name, text: flat[i + 1] ?? "" }] : []));
    return { round: this.module.cycle_count()[0] ?? 0, now: this.module.stage(), stages };
  }

  explore(): void {
    this.module.explore();
    this.#commanded();
  }

  manual(): void {
    this.module.manual();
    this.#commanded();
  }

  goTo(x: number, y: number): void {
    this.module.go_to(x, y);
    this.#commanded();
  }

  drive(forward: number, turn: number): void {
    this.module.drive(forward, turn);
    this.#commanded();
  }

  setDoor(index: number, open: boolean): void {
    this.module.set_door(index, open);
    this.note("info", `Door ${index + 1}: told to ${open ? "open" : "shut"}`);
  }

  stop(): void {
    this.module.stop();
    this.note("info", "Stop");
    this.#commanded();
  }

  bench(trial: BenchTrial): BenchResponse {
    const answer = this.module.bench(trial.forward, trial.mismatch, trial.pull, trial.pullAt, trial.seconds);
    const { seconds, wished, speeds, headings } = answer;
    answer.free();
    return { seconds, wished, speeds, headings };
  }

  moment(): Moment {
    const mode = this.module.mode() as Mode;
    const activity = this.module.activity();
    return this.read((s) => ({
      ...this.momentOf(s), source: this.kind, mode, reason: s.finished ? activity : "",
      activity: s.finished ? "" : errand(mode, activity, s.x, s.y, s.goal_x, s.goal_y),
      explored: this.#explored.value, beamHalfAngle: this.#beamHalfAngle,
    }));
  }

  change(): Change {
    const { module } = this;
    const now = performance.now();
    const plan = now - this.#planAt >= PLAN_PERIOD;
    if (plan) this.#planAt = now;
    const truth = this.#truthSent ? null : module.truth();
    const materials = this.#truthSent ? null : module.materials();
    const told = this.#reports !== this.#reportsSent;
    this.#reportsSent = this.#reports;
    this.#truthSent = true;
    return {
      ...this.slamChange(),
      truth,
      doors: this.#freshDoors(),
      materials,
      cycle: told ? this.#cycle() : null,
      inCycle: module.in_cycle(),
      movers: module.movers(),
      path: this.#fresh("path", module.path()),
      rawPath: plan ? this.#fresh("rawPath", module.raw_path()) : null,
      tree: plan ? this.#fresh("tree", module.tree()) : null,
      frontiers: plan ? this.#fresh("frontiers", module.frontiers()) : null,
      trail: this.#trail.take(),
      trailAnew: false,
      twin: null,
      twinAnew: false,
    };
  }

  /** Doors move by their own times too, so they are compared rather than remembered. */
  #freshDoors(): Float32Array | null {
    const now = this.module.doors();
    if (same(now, this.#doors)) return null;
    this.#doors = now.slice();
    return now;
  }

  /** What differs from what the page has; null where it is the same. */
  #fresh(name: PlanPart, now: Float32Array): Float32Array | null {
    const before = this.#sent[name];
    if (same(before, now)) return null;
    // The page takes over what it is sent, so a copy stays.
    this.#sent[name] = now.slice();
    return now;
  }

  /** After a command: what it changed is shown and told at once, and a run that had ended is alive again. */
  #commanded(): void {
    this.#planAt = -Infinity;
    this.#errands += 1;
    this.read((s) => this.#look(s, 0));
  }

  /** Keeps what plots, trails and log need of the step just made. */
  #look(s: RunStatus, millis: number): void {
    this.time = s.time;
    this.finished = s.finished;
    this.#reports = this.module.cycle_count()[1] ?? 0;
    this.#trail.add([s.truth_x, s.truth_y, s.odometry_x, s.odometry_y, s.x, s.y]);
    if (s.scans > this.scans) {
      this.scans = s.scans;
      this.sample(s, millis, this.#explored.value);
    }
    this.#tellGoal(s);
    this.#tellProgress(s);
  }

  #tellGoal(s: RunStatus): void {
    const goal = Number.isFinite(s.goal_x) ? `(${s.goal_x.toFixed(2)}, ${s.goal_y.toFixed(2)}) m` : "";
    if (goal === this.#told.goal) return;
    this.#told.goal = goal;
    if (goal === "") return;
    const planner = this.module.planner();
    const by = planner ? `, way found by ${plannerTitle(planner)}` : "";
    if (this.module.activity() === "homeward") {
      this.note("info", `All is explored: drives home to ${goal}${by}`, `home ${this.#errands}`);
      return;
    }
    // An explorer looks for the best frontier again and again: that is one story, not a hundred.
    const isLeg = this.module.mode() === "explore";
    this.note("info", isLeg ? `Heads for a frontier at ${goal}${by}` : `Goal ${goal}${by}`, `errand ${this.#errands}`);
  }

  #tellProgress(s: RunStatus): void {
    const end = s.finished ? this.module.activity() : "";
    const ends = end !== this.#told.end && end !== "";
    if (ends) {
      this.#explored.refresh();
      this.knownArea.refresh();
    }
    const reached = MILESTONES.filter((part) => this.#explored.value >= part);
    if (reached.length > this.#told.milestones) {
      this.note("info", `${Math.round(100 * (reached.at(-1) ?? 0))} % of what can be reached is known, after ${s.distance.toFixed(1)} m`);
    }
    if (s.contacts > this.#told.contacts) this.note("warn", "Touched something", "contact");
    if (ends) this.note(/^(goal|explored)(?!.*not home again)/.test(end) ? "good" : "warn", end.charAt(0).toUpperCase() + end.slice(1));
    this.#told = { ...this.#told, end, contacts: s.contacts, milestones: Math.max(this.#told.milestones, reached.length) };
  }
}

function same(a: Float32Array, b: Float32Array): boolean {
  return a.length === b.length && a.every((number, i) => number === b[i]);
}
