// The one shape that all sources of the worker share.

import type { Known, WebContest } from "../../pkg/slamlab_web.js";
import type { LogLevel, SavedFile, SavedKind } from "../protocol.js";
import type { ContestAsk, FieldChange, FieldName, GrowthName, Inspection, MethodName, Rooms, SigmaCurve, SourceKind } from "../protocol/module.js";
import type { Frame, Status } from "../protocol/frame.js";

/** What changed since the last call; the worker adds run, number and pace. */
export type Change = Omit<Frame, "kind" | "run" | "seq" | "clock" | "status" | "inspection" | "rooms" | "field">;

/** A status without the pace, which only the worker knows. */
export type Moment = Omit<Status, "realTimeFactor" | "remaining">;

export interface Note {
  time: number;
  level: LogLevel;
  text: string;
  /** Of several notes with the same topic only the newest stands, with their number. */
  topic?: string;
  /** It is shown at once, not only in the log. */
  alert?: boolean;
}

export interface Source {
  readonly kind: SourceKind;
  readonly title: string;
  readonly method: MethodName;
  /** Seconds of simulation or recording so far. */
  readonly time: number;
  readonly finished: boolean;
  /** Scans processed so far. */
  readonly scans: number;
  /** Grows with everything that may change the inside of the filter. */
  readonly version: number;
  /** The smallest step forward. */
  step(): void;
  moment(): Moment;
  change(): Change;
  /** The inside of the filter, with the matrix or without; null for methods without a line filter. */
  inspect(matrix: boolean): Inspection | null;
  /** Rooms and doors of the map; null where the grid is as it was when they were told last. */
  rooms(): Rooms | null;
  /** They are told anew when they are next asked for. */
  forgetRooms(): void;
  /** A field of the grid where it may have changed; null where it is as it was when it was told last. */
  field(name: FieldName): FieldChange | null;
  /** It is told anew when it is next asked for. */
  forgetField(): void;
  /** σ(ρ) of the sensor from scans taken standing; throws in words where it cannot be told. */
  estimateSigma(growth: GrowthName): SigmaCurve;
  /** What happened since the last call, for the log. */
  notes(): Note[];
  /** All planners on one query; throws in words where it cannot be asked. */
  contest(ask: ContestAsk): WebContest;
  /** The map as it is now, to be found in; throws in words where it holds no wall. */
  asKnown(): Known;
  hash(): string;
  /** Files to save; throws in words where there is nothing to be saved. */
  export(what: SavedKind): SavedFile[];
  close(): void;
}
