// Angles: radians between page and module, degrees on the screen.

export function degrees(radians: number): number {
  return (radians * 180) / Math.PI;
}

/** The turn from `b` to `a`, in (-π, π]. */
export function turnBetween(a: number, b: number): number {
  return Math.atan2(Math.sin(a - b), Math.cos(a - b));
}
