// One state of the run: its current figures, and what changed. Bulk data are flat typed arrays,
// transferred rather than copied.

import type { Cycle, FieldChange, GridChange, Inspection, Rooms, RunStatus, SourceKind, Submaps } from "./module.js";

/** One submap was taken out, or put back: those behind it are numbered anew. */
export interface Renumbering { readonly submap: number; readonly by: -1 | 1 }

/** Submaps as they changed; after a renumbering all of them come again. */
export interface SubmapsChange extends Submaps { readonly renumbered: readonly Renumbering[] }


/** The current figures. NaN where there is none (no truth in a recording). */
export interface Status extends RunStatus {
  source: SourceKind;
  /** Seconds of `time` for each second of the wall clock, over the last second or so. */
  realTimeFactor: number;
  /** Recordings: seconds left at the present pace. */
  remaining: number;
  /** Why it ended, in words. */
  reason: string;
  /** What the robot is about to do, in words. */
  activity: string;
  /** Distance between estimate and truth, m, and its heading, rad. */
  positionError: number;
  headingError: number;
  /** Distance between dead reckoning and truth, m. */
  odometryError: number;
  /** Fraction of the reachable area that is known, 0 to 1. */
  explored: number;
  /** Area known to be free, m². */
  knownArea: number;
  features: number;
}

/** What the time of the run is meant to be at any wall time, so that pictures can be drawn between
    two steps. */
export interface Clock {
  /** Milliseconds since 1970, comparable between page and worker. */
  wall: number;
  /** Seconds of the run at that wall time. */
  time: number;
  /** Seconds of the run for each second; 0 where the run stands still or goes as fast as it can. */
  rate: number;
}

/** What a run changed. Arrays are flat; null where nothing changed since the frame before. */
export interface Change {
  grid: GridChange | null;
  /** The map was redrawn: all earlier blocks are void. */
  gridReset: boolean;
  /** x y of what the last scan hit. */
  scan: Float32Array | null;
  /** How each of these was read, see BEAM. */
  beams: Float32Array | null;
  /** x1 y1 x2 y2 of the lines found in it. */
  found: Float32Array | null;
  /** Walls of the line map, see LINE. */
  lines: Float64Array | null;
  /** Landmarks with their confidence, see LANDMARK. */
  landmarks: Float32Array | null;
  /** How well they are found again, gate by gate, see REFINDING; empty without a truth. */
  refinding: Float32Array | null;
  /** What the stages of the cycle gave. */
  cycle: Cycle | null;
  /** Whether the robot drives by the cycle. */
  inCycle: boolean;
  /** Doors of the simulated world, see DOOR. */
  doors: Float32Array | null;
  /** x1 y1 x2 y2 of the true walls, without doors. */
  truth: Float32Array | null;
  /** What each of them is made of: 0 opaque, 1 glass, 2 dark. */
  materials: Uint8Array | null;
  /** x1 y1 x2 y2 of the walls of the prior map; empty for other methods. */
  priorMap: Float32Array | null;
  /** Poses that the robot may have, see HYPOTHESIS; empty where it knows. */
  hypotheses: Float32Array | null;
  /** x y of the particles behind them. */
  particles: Float32Array | null;
  /** What the run follows of that, see TRACK. */
  tracks: Float32Array | null;
  /** x y of what the last scan hit that was kept out of pose and map. */
  takenOut: Float32Array | null;
  /** x y radius of what truly walks about. */
  movers: Float32Array | null;
  /** x y of the legs still to drive. */
  path: Float32Array | null;
  /** x y of the path as the planner found it, before it was shortened. */
  rawPath: Float32Array | null;
  /** x1 y1 x2 y2 of the edges of the search tree. */
  tree: Float32Array | null;
  /** x y of the cells on the border between known and unknown. */
  frontiers: Float32Array | null;
  /** New points of the trails, see TRAIL; all of them where `trailReset`. */
  trail: Float32Array | null;
  trailReset: boolean;
  /** What was changed by hand, see EDIT. */
  edits: Float32Array | null;
  /** Submaps and loop closures, where they changed. */
  submaps: SubmapsChange | null;
  /** New samples of the twin, see TWIN. */
  twin: Float64Array | null;
  /** Another twin began with them, or there is none any more. */
  twinReset: boolean;
  /** New samples for the plots, see SAMPLE. */
  samples: Float64Array | null;
}

/** What the page asked for beside the run; null where it was not asked for, or has not changed. */
export interface Requested {
  /** The inside of the filter; null also where there is no line filter. */
  inspection: Inspection | null;
  rooms: Rooms | null;
  /** Points found in the last scan, see POINT. */
  points: Float32Array | null;
  /** The map that the wheels alone would have drawn, where it changed. */
  wheels: GridChange | null;
  field: (FieldChange & { reset: boolean }) | null;
}

/** One state of the run. */
export interface Frame extends Change, Requested {
  kind: "frame";
  /** Number of the run; frames of a run that was left are dropped. */
  run: number;
  /** Grows by one with each frame of a run. */
  seq: number;
  clock: Clock;
  status: Status;
}

/** The arrays of a frame that change hands. */
export function transferables(frame: Frame): ArrayBuffer[] {
  const objects = [frame, frame.grid, frame.wheels, frame.field?.grid, frame.inspection, frame.submaps].filter((object) => object !== null && object !== undefined);
  const buffers = new Set<ArrayBuffer>();
  for (const value of objects.flatMap((object) => Object.values(object) as unknown[])) {
    if (ArrayBuffer.isView(value) && value.buffer instanceof ArrayBuffer) buffers.add(value.buffer);
  }
  return [...buffers];
}
