// What other methods made of the same log, for comparison with the run that is shown.

import { TRAIL, TRAIL_STRIDE, type MethodName } from "./protocol/module.js";
import { SAMPLE } from "./protocol/sample.js";
import type { Store } from "./store.js";
import type { Scene } from "./view/scene.js";

/** A run in the state in which it was left. */
export interface Compared {
  readonly method: MethodName;
  /** Index of its method among those offered. */
  readonly place: number;
  /** See TRAIL. */
  readonly trail: Float32Array;
  readonly scans: number;
  /** The part of the log that was processed, 0 to 1. */
  readonly progress: number;
  readonly loopClosures: number;
  /** Median time for one scan, milliseconds. */
  readonly scanMillis: number;
}

/** The run that is shown; null before its first scan. */
export function shownRun({ method, status, history, offer }: Store, { trail, trailLength }: Scene): Compared | null {
  if (!status || trailLength === 0) return null;
  const { scans, progress, loopClosures } = status;
  const costs = (history.columns[SAMPLE.scanMillis] ?? []).filter(Number.isFinite).sort((a, b) => a - b);
  const place = offer.methods.findIndex(({ name }) => name === method);
  return { method, place, trail: trail.slice(0, trailLength), scans, progress, loopClosures, scanMillis: costs[costs.length >> 1] ?? NaN };
}

/** The distance between two trails at equal times, as long as both last: root mean square and
    maximum, m. Both begin at the origin of their map. */
export function apart(a: Float32Array, b: Float32Array): { rms: number; most: number } {
  let [squares, count, most, next] = [0, 0, 0, TRAIL_STRIDE];
  for (let i = 0; i + TRAIL_STRIDE <= b.length; i += TRAIL_STRIDE) {
    const time = b[i + TRAIL.time] ?? NaN;
    while (next < a.length && (a[next + TRAIL.time] ?? NaN) < time) next += TRAIL_STRIDE;
    if (next >= a.length) break;
    const at = (place: number): number => mix(a, next, place, time);
    const gap = Math.hypot((b[i + TRAIL.x] ?? NaN) - at(TRAIL.x), (b[i + TRAIL.y] ?? NaN) - at(TRAIL.y));
    [squares, count, most] = [squares + gap * gap, count + 1, Math.max(most, gap)];
  }
  return { rms: count > 0 ? Math.sqrt(squares / count) : NaN, most: count > 0 ? most : NaN };
}

/** A number of a trail at a time between two of its points; `next` is the second one. */
function mix(trail: Float32Array, next: number, place: number, time: number): number {
  const last = next - TRAIL_STRIDE;
  const [from, to] = [trail[last + TRAIL.time] ?? NaN, trail[next + TRAIL.time] ?? NaN];
  const part = to > from ? Math.max(0, (time - from) / (to - from)) : 1;
  const [a, b] = [trail[last + place] ?? NaN, trail[next + place] ?? NaN];
  return a + (b - a) * part;
}
