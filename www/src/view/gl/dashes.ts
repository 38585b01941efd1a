// Patterns of dashes by number, for shaders: each is up to six lengths, device pixels.

/** Lengths of a pattern, and patterns at once. */
export const LENGTHS = 6;
export const MOST = 40;

export class Dashes {
  /** Lengths, then how long the pattern is as a whole, and a word of nothing. */
  readonly table = new Float32Array(MOST * 8);
  #known = new Map<string, number>();
  /** Grows when all patterns have gone. */
  generation = 0;

  /** -1 of a line without dashes. */
  numberOf(lengths: readonly number[], scale: number): number {
    if (lengths.length === 0) return -1;
    const pattern = lengths.length % 2 === 0 ? lengths : [...lengths, ...lengths];
    const key = pattern.map((length) => (length * scale).toFixed(2)).join();
    const known = this.#known.get(key);
    if (known !== undefined) return known;
    if (this.#known.size >= MOST) {
      this.#known.clear();
      this.generation += 1;
    }
    const number = this.#known.size;
    const row = this.table.subarray(8 * number, 8 * (number + 1)).fill(0);
    pattern.slice(0, LENGTHS).forEach((length, i) => (row[i] = length * scale));
    row[LENGTHS] = row.subarray(0, LENGTHS).reduce((all, length) => all + length, 0);
    this.#known.set(key, number);
    return number;
  }
}
