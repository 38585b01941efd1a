// What a run starts from: world, sensor, method, settings, and the map to be found in.

/** One of `Answer.ready.sensors`. */
export type SensorName = string;

export type MethodName = "line-ekf" | "scan-matching" | "known-map";

export type ModeName = "manual" | "goto" | "explore";

export type SourceKind = "sim" | "replay" | "bridge";

/** A name that the module knows, and what a person calls it. */
export interface Named {
  name: string;
  title: string;
}

/** What a simulated run starts from; the same setup gives the same bits. */
export interface Setup {
  /** Name of a built-in world, or of the dropped file where `worldJson` is given. */
  world: string;
  /** Text of a world file; null for a built-in world. */
  worldJson: string | null;
  sensor: SensorName;
  seed: number;
  method: MethodName;
  mode: ModeName;
  /** Scan standing, plan, one turn, one leg, again, whatever the sensor. */
  cycle: boolean;
  /** Settings that differ from their defaults, by their keys. */
  settings: SettingValues;
  /** Calibration of the rangers; null for that of the data sheet. */
  calibration: Pairs | null;
  /** The map that the method `known-map` finds the robot in; null for the walls of the world. */
  known: KnownMap | null;
}

/** A map to be found in, in the frame of its file; m and rad. */
export interface KnownMap {
  name: string;
  /** x1 y1 x2 y2 of each face; what is free lies to its left. */
  faces: Float64Array;
  /** How far they may be off: standard deviation. */
  sigma: number;
  /** Where the robot begins in it: x, y, heading. */
  start: readonly [number, number, number];
}

/** A file as it was dropped or chosen. */
export interface GivenFile {
  name: string;
  bytes: ArrayBuffer;
}

export type SettingValues = Readonly<Record<string, number>>;

/** Calibration pairs of a ranger as text, and what the characteristic is a polynomial of. */
export interface Pairs {
  text: string;
  variable: "volts" | "per-volt";
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
  /** Whether a change acts at once; otherwise when the run begins anew. */
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
