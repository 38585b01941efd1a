// What the module hands over once, as plain objects of the protocol; the module's own are freed.

import type { Calibration as WebCalibration, FitTable, PresetInfo, SettingInfo, SigmaCurve as WebSigmaCurve } from "../../pkg/slamlab_web.js";
import type { Calibration, DriveFit, GrowthName, SettingValues, SigmaCurve } from "../protocol/module.js";
import type { Preset, Setting } from "../protocol/setup.js";

/** Keys and their numbers, as the module takes them. */
export function listOf(settings: SettingValues): [string[], Float64Array] {
  return [Object.keys(settings), Float64Array.from(Object.values(settings))];
}

export function settingOf(info: SettingInfo): Setting {
  const { key, group, name, unit, low, high, kind, choices, at_once: atOnce, meaning, default: usual } = info;
  info.free();
  return { key, group, name, unit, low, high, kind: kind as Setting["kind"], choices, atOnce, meaning, default: usual };
}

export function presetOf(info: PresetInfo): Preset {
  const { group, name, meaning, keys, values } = info;
  info.free();
  return { group, name, meaning, values: Object.fromEntries(keys.map((key, i) => [key, values[i] ?? NaN])) };
}

export function calibrationOf(fit: WebCalibration): Calibration {
  const { ranges, volts, residuals, sigma, reverses_at: reversesAt, domain, curve_volts: curveVolts, curve_ranges: curveRanges } = fit;
  fit.free();
  return { ranges, volts, residuals, sigma, reversesAt, domain, curveVolts, curveRanges };
}

export function sigmaCurve(growth: GrowthName, estimate: WebSigmaCurve): SigmaCurve {
  const { scans, stretches, coefficients, errors, chi_squared: chiSquared, bins, curve_ranges: curveRanges, curve_sigmas: curveSigmas, truth } = estimate;
  estimate.free();
  return { growth, scans, stretches, coefficients, errors, chiSquared, bins, curveRanges, curveSigmas, truth };
}

export function driveFit(table: FitTable): DriveFit {
  const { words, numbers, reasons, keys, values, legs } = table;
  const parameters = Array.from({ length: words.length / 3 }, (_, i) => {
    const [name = "", unit = "", unknown = ""] = words.slice(3 * i);
    const [value = NaN, sigma = NaN, model = NaN] = numbers.slice(3 * i);
    return { name, unit, value, sigma, model, unknown };
  });
  const [used = 0, leftOut = 0] = legs;
  return { parameters, reasons, settings: Object.fromEntries(keys.map((key, i) => [key, values[i] ?? NaN])), legs: used, leftOut };
}
