// A recorded log through the same SLAM. It knows no truth, takes no commands, and ends.

import type { FitTable, RunStatus, WebReplay } from "../../pkg/slamlab_web.js";
import { type GrowthName, type MethodName, type SigmaCurve, TRAIL_STRIDE } from "../protocol/module.js";
import { sigmaCurve } from "./convert.js";
import { Trail } from "./feeds.js";
import { Run } from "./run.js";
import type { Change, Moment, Note } from "./source.js";
import { TwinFeed } from "./twin_feed.js";

/** The whole trail is fetched this often, wall milliseconds: closing a loop moves all of it. */
const TRAIL_PERIOD = 250;

export class ReplaySource extends Run<WebReplay> {
  readonly kind = "replay";
  #trailAt = -Infinity;
  #twin = new TwinFeed();
  #closures = 0;
  #cancelled = false;
  /** Way by the wheels, m, and where they were last. */
  #distance = 0;
  #wheels: readonly [number, number] | null = null;

  constructor(module: WebReplay, name: string, method: MethodName) {
    super(module, name, method);
    this.note("info", `Opened ${name}: ${module.summary()}`);
    this.#told();
  }

  estimateSigma(growth: GrowthName): SigmaCurve {
    return sigmaCurve(growth, this.module.estimate_sigma(growth));
  }

  fit(): FitTable {
    return this.module.fit();
  }

  step(): void {
    if (this.finished) return;
    const begin = performance.now();
    const more = this.module.step();
    const millis = performance.now() - begin;
    this.read((s) => this.#look(s, millis));
    this.#told();
    if (!more) this.#end(`End of the recording: ${this.scans} scans mapped`, "good");
  }

  /** Ends the run here; the map stays. */
  cancel(): void {
    if (this.finished) return;
    this.#cancelled = true;
    this.#end(`Cancelled after ${this.scans} scans; the map so far stays`, "warn");
  }

  moment(): Moment {
    const reason = this.#cancelled ? "cancelled" : "end of the recording";
    return this.read((s) => ({
      ...this.momentOf(s), source: this.kind, mode: "manual", reason: this.finished ? reason : "", activity: "",
      explored: NaN, distance: this.#distance, beamHalfAngle: 0,
    }));
  }

  change(): Change {
    const now = performance.now();
    const trail = this.finished || now - this.#trailAt >= TRAIL_PERIOD;
    if (trail) this.#trailAt = now;
    return {
      ...this.slamChange(),
      truth: null, doors: null, materials: null, cycle: null, inCycle: false, movers: null, path: null, rawPath: null, tree: null, frontiers: null,
      trail: trail ? thinned(this.module.trail()) : null,
      trailAnew: trail,
      twin: this.#twin.take(this.module),
      twinAnew: false,
    };
  }

  /** What is damaged or was missed. */
  #told(): void {
    for (const text of this.module.notes()) this.note("warn", text, text);
  }

  #look(s: RunStatus, millis: number): void {
    this.time = s.time;
    this.scans = s.scans;
    if (this.#wheels) this.#distance += Math.hypot(s.odometry_x - this.#wheels[0], s.odometry_y - this.#wheels[1]);
    this.#wheels = [s.odometry_x, s.odometry_y];
    this.sample(s, millis, NaN);
    if (s.loop_closures > this.#closures) {
      this.#closures = s.loop_closures;
      this.note("info", "Loop closed: the map was bent back into place", "loop");
    }
  }

  #end(text: string, level: Note["level"]): void {
    this.finished = true;
    // The last picture stands for good: it must not show the area of a moment before.
    this.knownArea.refresh();
    this.note(level, text);
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
