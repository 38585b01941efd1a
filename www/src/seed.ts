// Seeds that nobody chose.

/** Short enough to be read out. */
const BELOW = 100_000;

export function anySeed(): number {
  return Math.floor(Math.random() * BELOW);
}
