// Every message between the page and the worker, named once for both sides.
//
// Page -> worker: `Command`. Worker -> page: `Answer`. Bulk data crosses as transferable typed arrays inside of `Frame`, at
// most one frame for each picture drawn: the page answers a frame with `drawn`, and only then the next one is sent.
// All geometry is in the map frame (m, rad, x forward and y left of the robot's start pose), also the truth.

export type SensorName = "lidar" | "rangers";
export type MethodName = "line-ekf" | "scan-matching";
export type ModeName = "manual" | "goto" | "explore";
export type SourceKind = "sim" | "replay";

/** Worlds that come with the module. */
export const WORLDS = ["office", "arena", "doors", "corridor", "loop"] as const;

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
}

export type Command =
  | { kind: "start"; setup: Setup; play: boolean }
  | { kind: "replay"; name: string; bytes: ArrayBuffer; method: MethodName }
  | { kind: "play" }
  | { kind: "pause" }
  /** Advances to the next scan and pauses. */
  | { kind: "step" }
  /** Simulated seconds for each second; Infinity is as fast as it goes. */
  | { kind: "speed"; factor: number }
  | { kind: "explore" }
  | { kind: "manual" }
  /** Map frame, m. */
  | { kind: "goto"; x: number; y: number }
  /** Fractions of the robot's highest speeds in [-1, 1], until changed; forward and to the left. */
  | { kind: "drive"; forward: number; turn: number }
  | { kind: "stop" }
  /** Ends reading a log, and a replay where it stands; what was mapped stays. */
  | { kind: "cancel" }
  | { kind: "save" }
  | { kind: "drawn" };

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
  /** Way driven, m. */
  distance: number;
  contacts: number;
  /** Half length and half width of the robot, m. */
  halfLength: number;
  halfWidth: number;
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

/** Numbers for each landmark in `Frame.lines`: alpha, r, var alpha, cov alpha r, var r, x1, y1, x2, y2, matched in the last
 * scan (0 or 1), seen often enough to be a wall (0 or 1). */
export const LINE_STRIDE = 11;
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
  nees: 7,
} as const;
export const SAMPLE_STRIDE = 8;

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
  /** x y of what the last scan hit. */
  scan: Float32Array | null;
  lines: Float64Array | null;
  /** x1 y1 x2 y2 of the true walls. */
  truth: Float32Array | null;
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
  /** New samples for the plots. */
  samples: Float64Array | null;
}

export type LogLevel = "info" | "good" | "warn";

export interface SavedFile {
  name: string;
  mime: string;
  bytes: Uint8Array<ArrayBuffer>;
}

export type Answer =
  | { kind: "ready" }
  | { kind: "started"; run: number; source: SourceKind; title: string; setup: Setup | null; playing: boolean }
  | Frame
  /** A log is being read, so much of it is done (0 to 1); null: no longer. The run before stands still meanwhile. */
  | { kind: "reading"; name: string; done: number | null }
  | { kind: "playing"; playing: boolean }
  | { kind: "hash"; run: number; text: string }
  | { kind: "event"; run: number; time: number; level: LogLevel; text: string; topic?: string }
  | { kind: "saved"; files: SavedFile[] }
  /** Something could not be done; the state before stays. */
  | { kind: "failed"; text: string };

/** The arrays of a frame that change hands. */
export function transferables(frame: Frame): ArrayBuffer[] {
  const arrays = [
    frame.grid?.index, frame.grid?.cells, frame.scan, frame.lines, frame.truth, frame.movers, frame.path, frame.rawPath, frame.tree,
    frame.frontiers, frame.trail, frame.samples,
  ];
  const buffers = new Set<ArrayBuffer>();
  for (const array of arrays) {
    if (array && array.buffer instanceof ArrayBuffer) buffers.add(array.buffer);
  }
  return [...buffers];
}
