// How fast a source should go: its time against that of the wall.

import type { Clock } from "../protocol/frame.js";

/** Wall milliseconds over which the pace is taken. */
const PACE_MILLIS = 700;
/** Wall seconds that a slower machine may be behind before it stops running after them. */
const MOST_BEHIND = 0.25;

export class Pace {
  /** Seconds of the source for each second; Infinity is as fast as it goes. */
  speed = 1;
  /** Wall ms and source s from which it counts. */
  #anchor = { wall: 0, time: 0 };
  /** The same over the last second, and what it was: seconds of the source for each second. */
  #last = { wall: 0, time: 0, factor: NaN };

  get factor(): number {
    return this.#last.factor;
  }

  /** Counts from here on. */
  rebase(wall: number, time: number): void {
    this.#anchor = { wall, time };
    this.#last = { wall, time, factor: NaN };
  }

  /** Where the source should be by now, s. */
  target(wall: number): number {
    return this.speed === Infinity ? Infinity : this.#anchor.time + ((wall - this.#anchor.wall) / 1000) * this.speed;
  }

  /** A slower machine falls behind; it must not race when the load ends. */
  fallBehind(wall: number, time: number): void {
    if (this.speed !== Infinity && this.target(wall) - time > MOST_BEHIND * this.speed) this.#anchor = { wall, time };
  }

  measure(wall: number, time: number): void {
    if (wall - this.#last.wall < PACE_MILLIS) return;
    this.#last = { wall, time, factor: ((time - this.#last.time) * 1000) / (wall - this.#last.wall) };
  }

  /** By which the page moves the robot between two frames; it stands where the source does not run
      by the wall's time. */
  clock(runs: boolean): Clock {
    return { wall: performance.timeOrigin + this.#anchor.wall, time: this.#anchor.time, rate: runs && this.speed !== Infinity ? this.speed : 0 };
  }
}
