// What is found out of a sensor or a drive: calibration, σ(ρ), the fit of a robot and its twin, the motors on the bench.

import type { SettingValues } from "./setup.js";

/** A ranger's characteristic of the fifth degree and how well it fits; m and V. */
export interface Calibration {
  ranges: Float64Array;
  volts: Float64Array;
  /** Fitted less true range of each pair. */
  residuals: Float64Array;
  sigma: number;
  /** Volts at which the curve turns round; NaN where it does not. */
  reversesAt: number;
  /** Lowest and highest volts; beyond, they are clamped. */
  domain: Float64Array;
  curveVolts: Float64Array;
  curveRanges: Float64Array;
}

/** How σ of the range grows with the range. */
export type Growth = "linear" | "square";

/** Places of the numbers of each bin in `SigmaCurve.bins`; m. */
export const SIGMA_BIN = { range: 0, sigma: 1, error: 2, used: 3, clipped: 4 } as const;
export const SIGMA_BIN_STRIDE = 5;

/** σ(ρ) of a sensor as estimated from scans taken standing. */
export interface SigmaCurve {
  growth: Growth;
  scans: number;
  stretches: number;
  /** a, b, and the least σ to believe. */
  coefficients: Float64Array;
  /** Standard deviations of a and b. */
  errors: Float64Array;
  /** Misfit of the bins and its degrees of freedom. */
  chiSquared: Float64Array;
  bins: Float64Array;
  curveRanges: Float64Array;
  curveSigmas: Float64Array;
  /** What the simulation drew its noise with; empty where nobody knows. */
  truth: Float64Array;
}

/** A parameter that a drive told. */
export interface FittedParameter {
  name: string;
  unit: string;
  value: number;
  /** Standard error, and what the robot's model says; NaN for none. */
  sigma: number;
  model: number;
  /** Why the drive does not tell it; empty where it does. */
  unknown: string;
}

/** What a drive told of its robot. */
export interface DriveFit {
  parameters: readonly FittedParameter[];
  /** What could not be fitted at all, in words. */
  reasons: readonly string[];
  /** Settings that take what is known. */
  settings: SettingValues;
  legs: number;
  leftOut: number;
}

/** What is known better of a robot than it says itself: settings of the odometry; and whether a twin runs beside it. */
export interface Told {
  readonly preset: { readonly name: string; readonly settings: SettingValues } | null;
  readonly twin: boolean;
}

/** Places of the numbers of each sample of the twin, one for each scan: s, map frame in m and rad, then m and ° off with 3σ, and m. */
export const TWIN = { time: 0, x: 1, y: 2, heading: 3, positionOff: 4, positionSigma3: 5, headingOff: 6, headingSigma3: 7, ranges: 8 } as const;
export const TWIN_STRIDE = 9;

/** What is asked of the motors on the bench. */
export interface BenchTrial {
  /** Wished speed as a part of the robot's highest. */
  forward: number;
  /** Part by which the right motor's magnet is stronger than the controller believes. */
  mismatch: number;
  /** Pull back on the left track, N, and from when on, s. */
  pull: number;
  pullAt: number;
  /** How long, s. */
  seconds: number;
}

/** Its time series, all of one length. */
export interface BenchResponse {
  seconds: Float64Array;
  /** m/s. */
  wished: Float64Array;
  /** Left and right track with the controller, then without, m/s: four series one after the other. */
  speeds: Float64Array;
  /** Heading less the wished one with the controller, then without, rad. */
  headings: Float64Array;
}
