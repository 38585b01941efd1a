// What the plots show of each scan: the columns, and the source of their values.

import { degrees, turnBetween } from "../angle.js";
import type { RunStatus } from "./module.js";

/** Layout of a sample in `Frame.samples`; there is one for each scan. */
export const SAMPLE = {
  time: 0, positionError: 1, positionSigma3: 2, headingError: 3, headingSigma3: 4, scanMillis: 5, explored: 6,
  /** Mean over the last scans, and its 95 % band, see `ConsistencyWindow` of the core. */
  nees: 7, neesLow: 8, neesHigh: 9,
  /** The same for each degree of freedom of the innovations. */
  nis: 10, nisLow: 11, nisHigh: 12,
  /** Mean innovation of the matched features, with bounds at two σ: direction of walls, °, distance
      of walls, points ahead and aside, cm. */
  alpha: 13, alphaHigh: 14, alphaLow: 15, r: 16, rHigh: 17, rLow: 18, x: 19, xHigh: 20, xLow: 21, y: 22, yHigh: 23, yLow: 24,
  /** Of a match of the whole scan, mm. */
  residual: 25,
  /** Features of the scan. */
  seen: 26, matched: 27, new: 28,
} as const;
export const SAMPLE_STRIDE = Object.keys(SAMPLE).length;

export type Sample = Record<keyof typeof SAMPLE, number>;

/** What the plots need of a scan. */
export function sampleOf(s: RunStatus, scanMillis: number, explored: number): Sample {
  const { time, nees, neesLow, neesHigh, nis, nisLow, nisHigh, innovation: i } = s;
  const [alpha, r, x, y] = [within(i?.alpha, i?.alphaSigma, degrees(1)), within(i?.r, i?.rSigma, 100), within(i?.x, i?.xSigma, 100), within(i?.y, i?.ySigma, 100)];
  return {
    time, scanMillis, explored, nees, neesLow, neesHigh, nis, nisLow, nisHigh,
    positionError: Math.hypot(s.x - s.truthX, s.y - s.truthY),
    positionSigma3: 3 * Math.sqrt(largestVariance(s.covXx, s.covXy, s.covYy)),
    headingError: Math.abs(degrees(turnBetween(s.heading, s.truthHeading))),
    headingSigma3: degrees(3 * Math.sqrt(Math.max(0, s.covHeading))),
    alpha: alpha.value, alphaHigh: alpha.bound, alphaLow: -alpha.bound, r: r.value, rHigh: r.bound, rLow: -r.bound,
    x: x.value, xHigh: x.bound, xLow: -x.bound, y: y.value, yHigh: y.bound, yLow: -y.bound,
    residual: 1000 * s.scanResidual, seen: s.featuresSeen, matched: s.featuresMatched, new: s.featuresNew,
  };
}

/** An innovation in another unit, with two σ of it; NaN if there is none. */
function within(value = NaN, sigma = NaN, unit: number): { value: number; bound: number } {
  return { value: unit * value, bound: 2 * unit * sigma };
}

/** Variance along the most uncertain direction of a 2 x 2 covariance. */
function largestVariance(xx: number, xy: number, yy: number): number {
  return Math.max(0, (xx + yy) / 2 + Math.hypot((xx - yy) / 2, xy));
}
