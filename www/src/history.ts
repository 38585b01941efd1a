// Samples of the run for the plots, in columns that are thinned out, so that an hour costs no more
// than a minute.

import { SAMPLE, SAMPLE_STRIDE } from "./protocol/sample.js";

/** A plot is some 300 pixels wide: more samples cost time and show nothing. */
const MOST = 2000;
/** Times closer than this belong to one scan, s. */
const SAME_SCAN = 0.01;

export class History {
  /** One column for each number of a sample, see SAMPLE. */
  columns: number[][] = [];
  version = 0;
  /** One sample in this many is kept. */
  keep = 1;
  #count = 0;

  constructor(private readonly stride = SAMPLE_STRIDE) {
    this.clear();
  }

  clear(): void {
    this.columns = Array.from({ length: this.stride }, () => []);
    this.keep = 1;
    this.#count = 0;
    this.version += 1;
  }

  append(samples: Float64Array): void {
    for (let i = 0; i + this.stride <= samples.length; i += this.stride) {
      this.#count += 1;
      if (this.#count % this.keep !== 0) continue;
      this.columns.forEach((column, k) => column.push(samples[i + k] ?? NaN));
      if ((this.columns[0]?.length ?? 0) > MOST) this.#thin();
    }
    this.version += 1;
  }

  /** Puts improved values into columns: each sample gets the value at its time, NaN if there is
      none. Times rise. */
  correct(times: Float32Array, columns: readonly (readonly [column: number, values: Float32Array])[]): void {
    const mine = this.columns[SAMPLE.time] ?? [];
    let at = 0;
    const indices = mine.map((time) => {
      while (at + 1 < times.length && Math.abs((times[at + 1] ?? NaN) - time) <= Math.abs((times[at] ?? NaN) - time)) at += 1;
      return Math.abs((times[at] ?? NaN) - time) < SAME_SCAN ? at : -1;
    });
    for (const [column, values] of columns) this.columns[column] = indices.map((index) => values[index] ?? NaN);
    this.version += 1;
  }

  #thin(): void {
    this.keep *= 2;
    this.columns = this.columns.map((column) => column.filter((_, i) => i % 2 === 0));
  }
}
