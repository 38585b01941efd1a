// Collects data between two frames, and limits how often expensive requests are made.

import { type Sample, SAMPLE, SAMPLE_STRIDE } from "../protocol/sample.js";
import { TRAIL } from "../protocol/module.js";

/** A number that costs more than a step, so it is computed only a few times a second. */
export class Slow {
  static readonly PERIOD = 300;
  #at = -Infinity;
  #value = NaN;

  constructor(private readonly ask: () => number) {}

  get value(): number {
    const now = performance.now();
    if (now - this.#at > Slow.PERIOD) {
      this.#value = this.ask();
      this.#at = performance.now();
    }
    return this.#value;
  }

  /** Computes it again at the next frame. */
  refresh(): void {
    this.#at = -Infinity;
  }
}

/** A version of the map. */
export interface Version {
  readonly generation: number;
  readonly revision: number;
}

const NONE: Version = { generation: -1, revision: -1 };

/** Expensive work on the map, done rarely and for a small part of the time. */
export class Sparing {
  /** Wall milliseconds between two runs of the work: walls change slowly, and many cells are
      read. */
  static readonly MILLIS = 1000;
  /** The pause is also at least this many times as long as the work: a twentieth of the time at
      most, because the robot is driven in this worker too. */
  static readonly REST = 19;
  #due = -Infinity;
  #known = NONE;

  /** The result of `work` on the map, given the version of its last result. Null if it is not due;
      a run that stands still does not wait. */
  ask<T extends Version>(runs: boolean, work: (known: Version) => T | undefined): T | null {
    const before = performance.now();
    if (runs && before < this.#due) return null;
    const found = work(this.#known);
    const after = performance.now();
    this.#due = after + Math.max(Sparing.MILLIS, Sparing.REST * (after - before));
    this.#known = found ?? this.#known;
    return found ?? null;
  }

  /** Makes the next request due at once, without a known version. */
  refresh(): void {
    this.#due = -Infinity;
    this.#known = NONE;
  }
}

/** Collects numbers until a frame takes them. */
export class Samples {
  #values: number[] = [];

  add(sample: Sample): void {
    const at = this.#values.length;
    this.#values.length = at + SAMPLE_STRIDE;
    for (const key of Object.keys(SAMPLE) as (keyof typeof SAMPLE)[]) this.#values[at + SAMPLE[key]] = sample[key];
  }

  take(): Float64Array | null {
    if (this.#values.length === 0) return null;
    const taken = Float64Array.from(this.#values);
    this.#values = [];
    return taken;
  }
}

/** Points of the trails, one every few centimetres. */
export class Trail {
  static readonly SPACING = 0.03;
  #values: number[] = [];
  #last: [number, number] = [NaN, NaN];

  /** See TRAIL. */
  add(point: readonly number[]): void {
    const [x, y] = [point[TRAIL.x] ?? NaN, point[TRAIL.y] ?? NaN];
    if (Math.hypot(x - this.#last[0], y - this.#last[1]) < Trail.SPACING) return;
    this.#last = [x, y];
    this.#values.push(...point);
  }

  take(): Float32Array | null {
    if (this.#values.length === 0) return null;
    const taken = Float32Array.from(this.#values);
    this.#values = [];
    return taken;
  }
}
