// Random seeds, for when nobody chose one.

/** Short enough to be read aloud. */
const BELOW = 100_000;

export function anySeed(): number {
  return Math.floor(Math.random() * BELOW);
}
