// Every message between the registration lab and its worker.

import type { BasinAsk, CloudPair, Registered, RegistrationAdvice, RegistrationOffer } from "../protocol/module.js";

/** x y heading, m and rad. */
export type Pose = readonly [number, number, number];

export type LabCommand =
  | { kind: "pair"; name: string }
  /** A list of points in a file, for one of the two clouds. */
  | { kind: "file"; name: string; bytes: ArrayBuffer; role: Role }
  /** The clouds of later messages; `areScans` if a sensor stood at the origin of each. */
  | { kind: "clouds"; fixed: Float64Array; moving: Float64Array; areScans: boolean }
  /** Runs all these methods from one start; `truth` is the right pose, if it is known. */
  | { kind: "register"; start: Pose; methods: readonly string[]; truth: Pose | null }
  /** Asks for the correspondences of an iteration of these methods. */
  | { kind: "look"; methods: readonly string[]; iteration: number }
  | { kind: "basin"; ask: BasinAsk }
  | { kind: "basin-stop" };

/** Which of the two clouds. */
export type Role = "fixed" | "moving";

/** The result of a method, and its time in this browser. */
export interface Found extends Registered {
  method: string;
  millis: number;
}

export type LabAnswer =
  | { kind: "ready"; offer: RegistrationOffer }
  | { kind: "pair"; name: string; pair: CloudPair }
  | { kind: "file"; name: string; role: Role; points: Float64Array }
  | { kind: "registered"; found: readonly Found[]; advice: RegistrationAdvice | null; right: Pose | null }
  /** Rows of CORRESPONDENCE, method by method. */
  | { kind: "looked"; iteration: number; rows: readonly Float32Array[]; methods: readonly string[] }
  /** New rows of BASIN; `isOver` if there are no more. */
  | { kind: "basin"; cells: Float32Array; progress: number; isOver: boolean }
  /** Something failed; the state before stays. */
  | { kind: "failed"; text: string };
