// What the plots show of each scan: the columns, and where their values come from.

import { degrees, turnBetween } from "../angle.js";
import type { RunStatus } from "./module.js";

/** Numbers for each sample in `Frame.samples`, one for each scan. */
export const SAMPLE = {
  time: 0, positionError: 1, positionSigma3: 2, headingError: 3, headingSigma3: 4, scanMillis: 5, explored: 6,
  /** Mean of the last scans, and its 95 % band, see `ConsistencyWindow` of the core. */
  nees: 7, neesLow: 8, neesHigh: 9,
  /** The same for each degree of freedom of the innovations. */
  nis: 10, nisLow: 11, nisHigh: 12,
} as const;
export const SAMPLE_STRIDE = Object.keys(SAMPLE).length;

export type Sample = Record<keyof typeof SAMPLE, number>;

/** What the plots need of a scan. */
export function sampleOf(s: RunStatus, scanMillis: number, explored: number): Sample {
  const { time, nees, neesLow, neesHigh, nis, nisLow, nisHigh } = s;
  return {
    time, scanMillis, explored, nees, neesLow, neesHigh, nis, nisLow, nisHigh,
    positionError: Math.hypot(s.x - s.truthX, s.y - s.truthY),
    positionSigma3: 3 * Math.sqrt(largestVariance(s.covXx, s.covXy, s.covYy)),
    headingError: Math.abs(degrees(turnBetween(s.heading, s.truthHeading))),
    headingSigma3: degrees(3 * Math.sqrt(Math.max(0, s.covHeading))),
  };
}

/** Variance along the most uncertain direction of a 2 x 2 covariance. */
function largestVariance(xx: number, xy: number, yy: number): number {
  return Math.max(0, (xx + yy) / 2 + Math.hypot((xx - yy) / 2, xy));
}
