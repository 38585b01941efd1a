// What a run starts from, beside what the module says of it.

import type { SettingValues } from "./module.js";

/** Odometry settings that replace the robot's own calibration, and whether a twin runs beside
    it. */
export interface Tuning {
  readonly preset: { readonly name: string; readonly settings: SettingValues } | null;
  readonly twin: boolean;
}
