// Scans of the run, one every half metre or twenty degrees, for visitors who want to register two
// of them.

import type { Status } from "./protocol/frame.js";

/** A scan and its pose in the map. */
export interface Keyframe {
  /** Run time, s. */
  readonly time: number;
  /** x y heading in the map. */
  readonly pose: readonly [number, number, number];
  /** x y of its hits, map frame, m. */
  readonly hits: Float32Array;
}

const LEAST_SHIFT = 0.5;
const LEAST_TURN = 0.35;
const MOST = 40;
/** A scan with fewer hits is not worth keeping. */
const FEWEST = 20;

export class Keyframes {
  #all: Keyframe[] = [];

  /** Takes the last scan, if the robot has moved on since the last one kept. */
  take(status: Status, hits: Float32Array): void {
    if (hits.length < 2 * FEWEST) return;
    const last = this.#all.at(-1);
    if (last) {
      const [x, y, heading] = last.pose;
      const turn = Math.abs(Math.atan2(Math.sin(status.heading - heading), Math.cos(status.heading - heading)));
      if (Math.hypot(status.x - x, status.y - y) < LEAST_SHIFT && turn < LEAST_TURN) return;
    }
    this.#all.push({ time: status.time, pose: [status.x, status.y, status.heading], hits });
    if (this.#all.length > MOST) this.#all.shift();
  }

  clear(): void {
    this.#all = [];
  }

  /** The oldest first. */
  get all(): readonly Keyframe[] {
    return this.#all;
  }
}
