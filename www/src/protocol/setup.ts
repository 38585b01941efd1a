// What a run starts from, besides the types of the module.

import type { SettingInfo, SettingValues } from "./module.js";

/** Odometry settings that replace the robot's own calibration, and whether a twin runs beside
    it. */
export interface Tuning {
  readonly preset: { readonly name: string; readonly settings: SettingValues } | null;
  readonly twin: boolean;
}

/** Settings without the sensor's parameters, which mean nothing to another sensor. */
export function ofAnySensor(settings: SettingValues, infos: readonly SettingInfo[]): SettingValues {
  const figures = new Set(infos.filter(({ group }) => group === "Sensor").map(({ key }) => key));
  return Object.fromEntries(Object.entries(settings).filter(([key]) => !figures.has(key)));
}
