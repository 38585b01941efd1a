// Dash patterns by number, for shaders: each has up to six lengths, device pixels.

/** Most lengths in a pattern, and most patterns at once. */
export const LENGTHS = 6;
export const MOST = 40;

export class Dashes {
  /** For each pattern its lengths, its total length, and one unused word. */
  readonly table = new Float32Array(MOST * 8);
  #known = new Map<string, number>();
  /** Grows when all patterns are dropped. */
  generation = 0;

  /** The number of a pattern; -1 for a solid line. */
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
