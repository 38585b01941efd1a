// One state of the run: its current figures, and what changed. Bulk data are flat typed arrays,
// transferred rather than copied.

import type { Cycle, FieldChange, GridChange, Inspection, Rooms, RunStatus, SourceKind, Submaps } from "./module.js";

/** A submap was removed or put back: those behind it are renumbered. */
export interface Renumbering { readonly submap: number; readonly by: -1 | 1 }

/** Changed submaps; after a renumbering all of them are sent again. */
export interface SubmapsChange extends Submaps { readonly renumbered: readonly Renumbering[] }


/** The current figures. NaN if there is none (no truth in a recording). */
export interface Status extends RunStatus {
  source: SourceKind;
  /** Seconds of `time` per wall second, over the last second or so. */
  realTimeFactor: number;
  /** Recordings: seconds left at the present pace. */
  remaining: number;
  /** Why the run ended, in words. */
  reason: string;
  /** What the robot is about to do, in words. */
  activity: string;
  /** Position error of the estimate, m; the heading error is in rad. */
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

/** The intended run time at any wall time, so that pictures can be drawn between two steps. */
export interface Clock {
  /** Milliseconds since 1970, comparable between page and worker. */
  wall: number;
  /** Seconds of the run at that wall time. */
  time: number;
  /** Run seconds per wall second; 0 if the run stands still or goes as fast as possible. */
  rate: number;
}

/** What a run changed. Arrays are flat; null if nothing changed since the frame before. */
export interface Change {
  grid: GridChange | null;
  /** The map was redrawn: all earlier blocks are invalid. */
  gridReset: boolean;
  /** x y of the hits of the last scan. */
  scan: Float32Array | null;
  /** How each beam was read, see BEAM. */
  beams: Float32Array | null;
  /** x1 y1 x2 y2 of the lines found in it. */
  found: Float32Array | null;
  /** Walls of the line map, see LINE. */
  lines: Float64Array | null;
  /** Landmarks with their confidence, see LANDMARK. */
  landmarks: Float32Array | null;
  /** How often landmarks are found again, gate by gate, see REFINDING; empty without a truth. */
  refinding: Float32Array | null;
  /** The results of the stages of the cycle. */
  cycle: Cycle | null;
  /** Whether the robot drives by the cycle. */
  inCycle: boolean;
  /** Doors of the simulated world, see DOOR. */
  doors: Float32Array | null;
  /** x1 y1 x2 y2 of the true walls, without doors. */
  truth: Float32Array | null;
  /** The material of each true wall: 0 opaque, 1 glass, 2 dark. */
  materials: Uint8Array | null;
  /** x1 y1 x2 y2 of the walls of the prior map; empty for other methods. */
  priorMap: Float32Array | null;
  /** Poses that the robot may have, see HYPOTHESIS; empty if it is localised. */
  hypotheses: Float32Array | null;
  /** x y of the particles behind the hypotheses. */
  particles: Float32Array | null;
  /** Tracks of moving things, see TRACK. */
  tracks: Float32Array | null;
  /** x y of the hits of the last scan that were taken out of pose and map. */
  takenOut: Float32Array | null;
  /** x y radius of the true walkers. */
  movers: Float32Array | null;
  /** x y of the legs still to drive. */
  path: Float32Array | null;
  /** x y of the path as the planner found it, before it was shortened. */
  rawPath: Float32Array | null;
  /** x1 y1 x2 y2 of the edges of the search tree. */
  tree: Float32Array | null;
  /** x y of the cells on the border between known and unknown. */
  frontiers: Float32Array | null;
  /** New points of the trails, see TRAIL; all points if `trailReset`. */
  trail: Float32Array | null;
  trailReset: boolean;
  /** Edits of the map, see EDIT. */
  edits: Float32Array | null;
  /** Submaps and loop closures, if they changed. */
  submaps: SubmapsChange | null;
  /** New samples of the twin, see TWIN. */
  twin: Float64Array | null;
  /** Another twin begins with these samples, or there is none any more. */
  twinReset: boolean;
  /** New samples for the plots, see SAMPLE. */
  samples: Float64Array | null;
}

/** Extras that the page asked for; null if not asked for, or unchanged. */
export interface Requested {
  /** The state of the filter; also null if there is no line filter. */
  inspection: Inspection | null;
  rooms: Rooms | null;
  /** Points found in the last scan, see POINT. */
  points: Float32Array | null;
  /** The map drawn by odometry alone, if it changed. */
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

/** The arrays of a frame to be transferred. */
export function transferables(frame: Frame): ArrayBuffer[] {
  const objects = [frame, frame.grid, frame.wheels, frame.field?.grid, frame.inspection, frame.submaps].filter((object) => object !== null && object !== undefined);
  const buffers = new Set<ArrayBuffer>();
  for (const value of objects.flatMap((object) => Object.values(object) as unknown[])) {
    if (ArrayBuffer.isView(value) && value.buffer instanceof ArrayBuffer) buffers.add(value.buffer);
  }
  return [...buffers];
}
