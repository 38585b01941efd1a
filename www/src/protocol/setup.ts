// What a run starts from, beside what the module says of it.

import type { SettingValues } from "./module.js";

/** A name that the module knows, and what a person calls it. */
export interface Named {
  name: string;
  title: string;
}

/** What is known better of a robot than it says itself: settings of the odometry; and whether a twin runs beside it. */
export interface Told {
  readonly preset: { readonly name: string; readonly settings: SettingValues } | null;
  readonly twin: boolean;
}

/** One setting of the core's table. */
export interface Setting {
  key: string;
  group: string;
  name: string;
  unit: string;
  low: number;
  high: number;
  kind: "real" | "whole" | "switch" | "choice";
  choices: readonly string[];
  /** Whether a change acts at once; otherwise when the run begins anew. */
  atOnce: boolean;
  meaning: string;
  default: number;
}

export interface Preset {
  group: string;
  name: string;
  meaning: string;
  values: SettingValues;
}
