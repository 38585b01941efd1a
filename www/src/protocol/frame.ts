// One state of the run: the numbers of the moment, and what changed. Bulk data are flat typed arrays that change hands.

import type { DiagnosisName, Inspection } from "./filter.js";
import type { Rooms } from "./rooms.js";
import type { ModeName, SourceKind } from "./setup.js";

/** The numbers of the moment. NaN where there is none (no truth in a recording). */
export interface Status {
  source: SourceKind;
  /** Seconds of simulation, or of the recording. */
  time: number;
  /** Seconds of `time` for each second of the wall clock, over the last second or so. */
  realTimeFactor: number;
  scans: number;
  /** Recordings: how much is done, 0 to 1. */
  progress: number;
  /** Recordings: seconds left at the present pace. */
  remaining: number;
  mode: ModeName;
  finished: boolean;
  /** Why it ended, in words. */
  reason: string;
  /** What the robot is about to do, in words. */
  activity: string;
  /** Goal of the pilot in the map frame, m; NaN while there is none. */
  goalX: number;
  goalY: number;
  /** Estimated pose, m and rad. */
  x: number;
  y: number;
  heading: number;
  /** Its covariance: xx, xy, yy (m²) and heading (rad²). */
  covXx: number;
  covXy: number;
  covYy: number;
  covHeading: number;
  /** True pose, m and rad. */
  truthX: number;
  truthY: number;
  truthHeading: number;
  /** Dead reckoning, m and rad. */
  odometryX: number;
  odometryY: number;
  odometryHeading: number;
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
  /** What the filter's consistency says. */
  diagnosis: DiagnosisName;
  /** Way driven, m. */
  distance: number;
  contacts: number;
  /** Half length and half width of the robot, m. */
  halfLength: number;
  halfWidth: number;
  /** Walls are touched by that rectangle; otherwise by the disc around it. */
  isRectangle: boolean;
  /** Half the opening of a sonar's cone, rad; 0 for a ray of light. */
  beamHalfAngle: number;
  /** Of what the sensor hit lately, the part that stands in the known map, 0 to 1; NaN without one, or before enough was seen. */
  knownPart: number;
  /** That is so little that it is another map, or the robot begins elsewhere in it. */
  knownMisfit: boolean;
}

/** The cycle of TDK 2016 §6.3: scan standing, plan, one turn, one leg, again. */
export interface Cycle {
  /** Scans asked for so far. */
  round: number;
  /** Name of the newest stage; empty before the first. */
  now: string;
  /** In the order in which they are done; what each gave last, empty before. */
  stages: readonly { readonly name: string; readonly text: string }[];
}

/** Grid blocks that changed since the frame before. */
export interface GridChange {
  /** Side of a cell, m. */
  resolution: number;
  /** Cells along one side of a block. */
  blockCells: number;
  /** Column and row of each block, in blocks. */
  index: Int32Array;
  /** Cells of each block in rows from the lower left: 0 unknown, else 1 + 254 p with p the probability of an obstacle. */
  cells: Uint8Array;
}

/** What can be told of each cell from its distance to the nearest wall: that, how well a beam's end fits there, the room around the robot's centre. */
export type FieldName = "distance" | "likelihood" | "room";

/** A field where it may have changed; cells as of a grid, but 1 + the value in steps, 255 for all that is more. */
export interface FieldChange extends GridChange {
  name: FieldName;
  /** All blocks so far are worth nothing. */
  anew: boolean;
  /** What a byte more means: m, of the likelihood 1/254. */
  step: number;
}

/** Places of the numbers of each landmark in `Frame.lines`: rad and m; the two flags are 0 or 1. */
export const LINE = {
  alpha: 0, r: 1, varAlpha: 2, covAlphaR: 3, varR: 4, x1: 5, y1: 6, x2: 7, y2: 8,
  /** Matched in the last scan. */
  matched: 9,
  /** Seen often enough to be a wall. */
  confirmed: 10,
  /** Its name, the same for its whole life. */
  id: 11,
} as const;
export const LINE_STRIDE = 12;

/** Numbers for each point in `Frame.trail`: truth x y, odometry x y, estimate x y. */
export const TRAIL_STRIDE = 6;

/** Numbers for each sample in `Frame.samples`, one for each scan. */
export const SAMPLE = {
  time: 0,
  positionError: 1,
  positionSigma3: 2,
  headingError: 3,
  headingSigma3: 4,
  scanMillis: 5,
  explored: 6,
  /** Mean of the last scans, and its 95 % band, see `ConsistencyWindow` of the core. */
  nees: 7,
  neesLow: 8,
  neesHigh: 9,
  /** The same for each degree of freedom of the innovations. */
  nis: 10,
  nisLow: 11,
  nisHigh: 12,
} as const;
export const SAMPLE_STRIDE = 13;

/** Places of the numbers of each hit in `Frame.beams`: m, and the sensor's own unit, NaN where it tells none. */
export const BEAM = { range: 0, sigma: 1, quality: 2 } as const;
export const BEAM_STRIDE = 3;

/** Places of the numbers of each door in `Frame.doors`: ends in the map frame, m, and flags, 0 or 1. */
export const DOOR = {
  x1: 0, y1: 1, x2: 2, y2: 3, open: 4,
  /** Whether it is to be open: one that is to shut waits while somebody stands in it. */
  ordered: 5,
} as const;
export const DOOR_STRIDE = 6;

/** What the time of the run is meant to be at any wall time, so that pictures can be drawn between two steps. */
export interface Clock {
  /** Milliseconds since 1970, comparable between page and worker. */
  wall: number;
  /** Seconds of the run at that wall time. */
  time: number;
  /** Seconds of the run for each second; 0 where the run stands still or goes as fast as it can. */
  rate: number;
}

/** One state of the run. Arrays are flat; null where nothing changed since the frame before. */
export interface Frame {
  kind: "frame";
  /** Number of the run; frames of a run that was left are dropped. */
  run: number;
  /** Grows by one with each frame of a run. */
  seq: number;
  clock: Clock;
  status: Status;
  grid: GridChange | null;
  /** All blocks so far are worth nothing: the map was drawn anew. */
  gridAnew: boolean;
  /** A field of the grid; null where none was asked for, or it is as it was. */
  field: FieldChange | null;
  /** x y of what the last scan hit. */
  scan: Float32Array | null;
  /** How each of these was read, see BEAM. */
  beams: Float32Array | null;
  /** x1 y1 x2 y2 of the lines found in it. */
  found: Float32Array | null;
  /** What the stages of the cycle gave; null where nothing changed. */
  cycle: Cycle | null;
  /** Whether the robot drives by the cycle. */
  inCycle: boolean;
  lines: Float64Array | null;
  /** Doors of the simulated world, see DOOR. */
  doors: Float32Array | null;
  /** x1 y1 x2 y2 of the true walls, without doors. */
  truth: Float32Array | null;
  /** Material of each of them: 0 opaque, 1 glass, 2 dark. */
  materials: Uint8Array | null;
  /** x1 y1 x2 y2 of the walls of the map that the robot is to be found in; empty for other methods. */
  known: Float32Array | null;
  /** x y radius of what walks about. */
  movers: Float32Array | null;
  /** x y of the legs still to drive. */
  path: Float32Array | null;
  /** x y of the path as the planner found it, before it was shortened. */
  rawPath: Float32Array | null;
  /** x1 y1 x2 y2 of the edges of the search tree. */
  tree: Float32Array | null;
  /** x y of the cells on the border between known and unknown. */
  frontiers: Float32Array | null;
  /** New points of the trails; all of them where `trailAnew`. */
  trail: Float32Array | null;
  trailAnew: boolean;
  /** New samples of the twin, see TWIN. */
  twin: Float64Array | null;
  /** Another twin began with them, or there is none any more. */
  twinAnew: boolean;
  /** New samples for the plots. */
  samples: Float64Array | null;
  /** The inside of the filter; null where it was not asked for, or there is no line filter. */
  inspection: Inspection | null;
  /** Rooms and doors; null where they were not asked for, or the grid is as it was. */
  rooms: Rooms | null;
}

/** The arrays of a frame that change hands. */
export function transferables(frame: Frame): ArrayBuffer[] {
  const arrays = [
    frame.grid?.index, frame.grid?.cells, frame.field?.index, frame.field?.cells, frame.scan, frame.beams, frame.doors, frame.found, frame.lines, frame.truth, frame.materials, frame.known, frame.movers, frame.path, frame.rawPath, frame.tree,
    frame.frontiers, frame.trail, frame.twin, frame.samples, frame.inspection?.landmarks, frame.inspection?.coefficients, frame.inspection?.sightings,
    frame.inspection?.candidates, frame.inspection?.odometry, frame.rooms?.regions, frame.rooms?.doors, frame.rooms?.corners, frame.rooms?.rings,
  ];
  const buffers = new Set<ArrayBuffer>();
  for (const array of arrays) {
    if (array && array.buffer instanceof ArrayBuffer) buffers.add(array.buffer);
  }
  return [...buffers];
}
