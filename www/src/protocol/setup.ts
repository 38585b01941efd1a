// What a run starts from, beside what the module says of it.

import type { SettingValues } from "./module.js";

/** A name that the module knows, and what a person calls it. */
export interface Named {
  name: string;
  title: string;
}

/** Odometry settings that replace the robot's own calibration, and whether a twin runs beside it. */
export interface Tuning {
  readonly preset: { readonly name: string; readonly settings: SettingValues } | null;
  readonly twin: boolean;
}

/** One setting of the core's table. */
export interface Setting {
  key: string;
  group: string;
  name: string;
  /** As people read it: `scale` times the number. */
  unit: string;
  scale: number;
  /** Range and default as stored, SI. */
  low: number;
  high: number;
  kind: "real" | "whole" | "switch" | "choice";
  choices: readonly string[];
  /** Whether a change acts at once; otherwise at the next start of the run. */
  atOnce: boolean;
  /** Whether it is among the few that everybody meets first. */
  isBasic: boolean;
  meaning: string;
  default: number;
  /** The setting that it depends on, empty for none, and the numbers of that one; none: all above 0. */
  needs: string;
  needed: readonly number[];
  /** Why it has no effect on this run; empty where it has. */
  idle: string;
}

export interface Preset {
  group: string;
  name: string;
  meaning: string;
  values: SettingValues;
}
