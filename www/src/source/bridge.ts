// A robot behind a bridge: the module estimates, maps and drives; the link carries its bytes.

import type { FitTable, RunStatus, WebLive } from "../../pkg/slamlab_web.js";
import type { GrowthName, MethodName, Mode, SettingValues, SigmaCurve } from "../protocol/module.js";
import { listOf } from "./convert.js";
import { errand } from "./errand.js";
import { Trail } from "./feeds.js";
import { type Link, micros } from "./link.js";
import { Run } from "./run.js";
import type { Change, Moment, Note } from "./source.js";
import { TwinFeed } from "./twin_feed.js";

export class BridgeSource extends Run<WebLive> {
  readonly kind = "bridge";
  readonly link: Link;
  /** Which beginning of the estimate this run shows. */
  readonly begun: number;
  #trail = new Trail();
  #twin = new TwinFeed();
  #twinAnew = false;
  #path = new Float32Array(0);

  constructor(module: WebLive, link: Link, title: string, method: MethodName) {
    super(module, title, method);
    this.link = link;
    this.begun = module.begun();
  }

  /** Something came over the link. */
  moved(): void {
    this.read((s) => this.#look(s));
  }

  /** A robot goes at its own pace. */
  step(): void {}

  estimateSigma(_growth: GrowthName): SigmaCurve {
    throw new Error("σ(ρ) is estimated from a recording: record the standing robot, and open the recording here.");
  }

  fit(): FitTable {
    return this.module.fit();
  }

  /** What is known better of the robot than it says; with a twin, another one begins here. */
  tell(settings: SettingValues, twin: boolean): void {
    this.module.configure(...listOf(settings));
    this.module.set_twin(twin, ...listOf(settings));
    this.#twin.again();
    this.#twinAnew = true;
  }

  explore(): void {
    this.module.explore();
  }

  manual(): void {
    this.module.manual();
  }

  goTo(x: number, y: number): void {
    this.module.go_to(x, y);
  }

  drive(forward: number, turn: number): void {
    this.module.drive(forward, turn);
  }

  wheel(take: boolean, force: boolean): void {
    if (take) this.module.take_wheel(micros(), force);
    else this.module.leave_wheel(micros());
    this.#said();
  }

  stop(): void {
    this.module.stop(micros());
    this.note("info", "Stop");
    this.#said();
  }

  emergency(on: boolean): void {
    if (on) this.module.emergency_stop(micros());
    else this.module.reset_emergency_stop(micros());
    this.#said();
  }

  override notes(): Note[] {
    const told = this.module.notes();
    for (let i = 0; i + 1 < told.length; i += 2) this.note(told[i] === "info" ? "info" : "warn", told[i + 1] ?? "", told[i + 1]);
    return super.notes();
  }

  moment(): Moment {
    const mode = this.module.mode() as Mode;
    const activity = this.module.activity();
    return this.read((s) => ({
      ...this.momentOf(s), source: this.kind, mode,
      // The errand has ended, not the run: a robot at a bridge goes on telling what it sees.
      finished: s.finished, reason: s.finished ? activity : "",
      activity: s.finished ? "" : errand(mode, activity, s.x, s.y, s.goal_x, s.goal_y),
      explored: NaN, beamHalfAngle: 0,
    }));
  }

  change(): Change {
    const path = this.module.path();
    const isNew = path.length !== this.#path.length || path.some((number, i) => number !== this.#path[i]);
    if (isNew) this.#path = path.slice();
    const twinAnew = this.#twinAnew;
    this.#twinAnew = false;
    return {
      ...this.slamChange(),
      truth: null, doors: null, materials: null, cycle: null, inCycle: false, movers: null, rawPath: null, tree: null, frontiers: null,
      path: isNew ? path : null,
      trail: this.#trail.take(),
      trailAnew: false,
      twin: this.#twin.take(this.module),
      twinAnew,
    };
  }

  /** Link and module are the worker's: they outlive a run. */
  override close(): void {}

  #said(): void {
    this.link.flush();
    this.link.stir();
  }

  #look(s: RunStatus): void {
    this.time = s.time;
    this.#trail.add([NaN, NaN, s.odometry_x, s.odometry_y, s.x, s.y]);
    if (s.scans > this.scans) {
      this.scans = s.scans;
      // A scan is taken in where its message is; what it costs is not told apart.
      this.sample(s, NaN, NaN);
    }
  }
}
