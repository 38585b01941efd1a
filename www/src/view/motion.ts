// Interpolates between steps: the run moves 20 times a second, the screen 60 times.
//
// The run is drawn at the time of its clock, minus the delay from worker to screen. The worker is
// up to a step ahead of that clock, so this time lies between two computed states, and nothing is
// extrapolated. A run that is paused, or goes as fast as possible, is drawn in its newest state.

import { turnBetween } from "../angle.js";
import type { Clock, Frame, Status } from "../protocol/frame.js";

/** How far behind its clock a run is drawn: one picture of the screen, wall seconds, */
const DELAY_SECONDS = 0.02;
/** but at most this, run seconds: if steps come faster than pictures there is little to smooth. */
const DELAY_MOST = 0.1;
/** States kept: the drawn time may lie before the last two. */
const KEPT = 4;
/** Over a longer gap between two states, run seconds, nothing is interpolated. */
const GAP = 1;

export interface Instant {
  readonly status: Status;
  /** x y radius of the walkers. */
  readonly movers: Float32Array;
}

const STILL: Clock = { wall: 0, time: 0, rate: 0 };

export class Motion {
  #kept: Instant[] = [];
  #clock: Clock = STILL;

  clear(): void {
    this.#kept = [];
    this.#clock = STILL;
  }

  take(frame: Frame): void {
    const last = this.#kept.at(-1);
    const instant = { status: frame.status, movers: frame.movers ?? last?.movers ?? new Float32Array(0) };
    this.#clock = frame.clock;
    // A step sent again (after a command, say) replaces the earlier one.
    if (last && last.status.time >= frame.status.time) this.#kept.pop();
    this.#kept.push(instant);
    if (this.#kept.length > KEPT) this.#kept.shift();
  }

  /** The state at a wall time, milliseconds since 1970; null before the first frame. */
  at(wall: number): Instant | null {
    const newest = this.#kept.at(-1);
    const { rate } = this.#clock;
    if (!newest || rate === 0) return newest ?? null;
    const time = this.#clock.time + ((wall - this.#clock.wall) / 1000) * rate - Math.min(DELAY_SECONDS * rate, DELAY_MOST);
    if (time >= newest.status.time) return newest;
    const next = this.#kept.findIndex((instant) => instant.status.time > time);
    const [a, b] = [this.#kept[next - 1], this.#kept[next]];
    if (!a || !b || b.status.time - a.status.time > GAP) return b ?? newest;
    return between(a, b, (time - a.status.time) / (b.status.time - a.status.time));
  }
}

const MIXED = ["time", "x", "y", "covXx", "covXy", "covYy", "covHeading", "truthX", "truthY", "odometryX", "odometryY"] as const;
const TURNED = ["heading", "truthHeading", "odometryHeading"] as const;

/** `part` of the way from `a` to `b`. */
function between(a: Instant, b: Instant, part: number): Instant {
  const status = { ...b.status };
  for (const key of MIXED) status[key] = a.status[key] + (b.status[key] - a.status[key]) * part;
  for (const key of TURNED) status[key] = a.status[key] + turnBetween(b.status[key], a.status[key]) * part;
  const movers = a.movers.length === b.movers.length ? b.movers.map((value, i) => (a.movers[i] ?? value) * (1 - part) + value * part) : b.movers;
  return { status, movers };
}
