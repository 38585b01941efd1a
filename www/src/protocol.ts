// Every message between the page and the worker, named once for both sides.
//
// Page -> worker: `Command`. Worker -> page: `Answer`. Bulk data crosses as transferable typed arrays inside of `Frame`, at
// most one frame for each picture drawn: the page answers a frame with `drawn`, and only then the next one is sent.
// All geometry is in the map frame (m, rad, x forward and y left of the robot's start pose), also the truth.

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

/** A ranger's characteristic of the fifth degree and how well it fits; m and V. */
export interface Calibration {
  ranges: Float64Array;
  volts: Float64Array;
  /** Fitted less true range of each pair. */
  residuals: Float64Array;
  sigma: number;
  /** Volts at which the curve turns round; NaN where it does not. */
  reversesAt: number;
  /** Lowest and highest volts; beyond, they are clamped. */
  domain: Float64Array;
  curveVolts: Float64Array;
  curveRanges: Float64Array;
}

/** How σ of the range grows with the range. */
export type Growth = "linear" | "square";

/** Places of the numbers of each bin in `SigmaCurve.bins`; m. */
export const SIGMA_BIN = { range: 0, sigma: 1, error: 2, used: 3, clipped: 4 } as const;
export const SIGMA_BIN_STRIDE = 5;

/** σ(ρ) of a sensor as estimated from scans taken standing. */
export interface SigmaCurve {
  growth: Growth;
  scans: number;
  stretches: number;
  /** a, b, and the least σ to believe. */
  coefficients: Float64Array;
  /** Standard deviations of a and b. */
  errors: Float64Array;
  /** Misfit of the bins and its degrees of freedom. */
  chiSquared: Float64Array;
  bins: Float64Array;
  curveRanges: Float64Array;
  curveSigmas: Float64Array;
  /** What the simulation drew its noise with; empty where nobody knows. */
  truth: Float64Array;
}

/** A parameter that a drive told. */
export interface FittedParameter {
  name: string;
  unit: string;
  value: number;
  /** Standard error, and what the robot's model says; NaN for none. */
  sigma: number;
  model: number;
  /** Why the drive does not tell it; empty where it does. */
  unknown: string;
}

/** What a drive told of its robot. */
export interface DriveFit {
  parameters: readonly FittedParameter[];
  /** What could not be fitted at all, in words. */
  reasons: readonly string[];
  /** Settings that take what is known. */
  settings: SettingValues;
  legs: number;
  leftOut: number;
}

/** What is known better of a robot than it says itself: settings of the odometry; and whether a twin runs beside it. */
export interface Told {
  readonly preset: { readonly name: string; readonly settings: SettingValues } | null;
  readonly twin: boolean;
}

/** Places of the numbers of each sample of the twin, one for each scan: s, map frame in m and rad, then m and ° off with 3σ, and m. */
export const TWIN = { time: 0, x: 1, y: 2, heading: 3, positionOff: 4, positionSigma3: 5, headingOff: 6, headingSigma3: 7, ranges: 8 } as const;
export const TWIN_STRIDE = 9;

/** Where planners look: among the true walls, on the map with the unknown taken to be free, or only where it was seen. */
export type Ground = "truth" | "map" | "known";

/** What all planners are asked. */
export interface ContestAsk {
  ground: Ground;
  /** x y of the start, of the goal, map frame, m. */
  ends: readonly [number, number, number, number];
  /** Time of each planner, s. */
  seconds: number;
}

/** Places of the numbers of each planner in `ContestState.standings`: flags are 0 or 1, m, s; NaN without a path. */
export const STANDING = { over: 0, straight: 1, length: 2, ratio: 3, seconds: 4, iterations: 5, tried: 6 } as const;
export const STANDING_STRIDE = 7;

/** How all planners stand; lists in the order of their names. */
export interface ContestState extends ContestAsk {
  running: boolean;
  planners: readonly string[];
  standings: Float64Array;
  /** Why there is no path: blocked, proved, not-offered or open, and in words; rooms, and why the planner left the rooms on the way; empty otherwise. */
  reasons: readonly { readonly kind: string; readonly text: string }[];
  /** What lengths are held against, m, and whether there is no shorter path; NaN while there is no path. */
  shortest: number;
  isOptimum: boolean;
  /** x y of the corners. */
  paths: readonly Float32Array[];
  /** Time taken, s, and length, m, whenever that became shorter. */
  curves: readonly Float64Array[];
  /** Whose tree this is, x1 y1 x2 y2. */
  watched: number;
  tree: Float32Array;
}

/** A device at a serial port that the page itself opened. */
export type SerialKind = "rp6" | "rplidar" | "ld06";

/** What happened at a line, by its number. */
export interface LineEvent {
  line: number;
  event: "opened" | "bytes" | "broken";
  bytes?: Uint8Array;
  /** When they came, ms since 1970: the worker may be busy when they do. */
  came?: number;
  /** Why it broke: cause and cure. */
  why?: string;
}

/** What the device at a line wants done with it. */
export interface LineWish {
  line: number;
  /** `well`: the next time that it breaks it is tried again soon. */
  want: "open" | "write" | "dtr" | "well" | "reopen" | "close";
  baud: number;
  bytes: Uint8Array<ArrayBuffer>;
  on: boolean;
}

/** To the worker with the rules for a robot at ports of this page. */
export type NearCommand =
  /** `driver` leads to the one who maps and drives; what goes over it are a bridge's messages. */
  | { kind: "begin"; devices: readonly SerialKind[]; driver: MessagePort }
  | ({ kind: "line" } & LineEvent)
  /** The person stops the robot; with `cutOff` its motors stay off. */
  | { kind: "stop"; cutOff: boolean }
  /** Has the lines closed, the robot stopped before. */
  | { kind: "end" };

/** And from it. */
export type NearAnswer =
  | ({ kind: "line" } & LineWish)
  /** The rules are of no use any more. */
  | { kind: "failed"; text: string };

export type Command =
  | { kind: "start"; setup: Setup; play: boolean }
  /** A building to drive in from files of others: a floor plan (.svg), OGmap.txt, or the YAML and the image of a map of ROS. It is answered by `built`. */
  | { kind: "build"; name: string; files: readonly GivenFile[] }
  /** The same, or a world, as a map to be found in; without files the map as the present run has drawn it. It is answered by `known`. */
  | { kind: "know"; name: string; files: readonly GivenFile[] }
  | { kind: "replay"; name: string; bytes: ArrayBuffer; method: MethodName; settings: SettingValues; known: KnownMap | null }
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
  /** Whether frames carry what goes on inside the filter, and whether with the matrix, which is long. */
  | { kind: "inspect"; on: boolean; matrix: boolean }
  /** Whether frames carry rooms and doors. */
  | { kind: "rooms"; on: boolean }
  /** Drive by the cycle, or continuously. */
  | { kind: "cycle"; on: boolean }
  /** Goes on to the end of the next stage of the cycle and pauses. */
  | { kind: "stage" }
  /** Settings that act at once: all that differ from their defaults. */
  | { kind: "configure"; settings: SettingValues }
  /** The settings that this sensor has, with these changes. */
  | { kind: "settings"; sensor: SensorName; settings: SettingValues }
  | { kind: "calibrate"; pairs: Pairs }
  /** σ(ρ) from a log's scans taken standing, or from those of a simulated robot that stands. */
  | { kind: "sigma"; growth: Growth }
  /** What the drive so far tells of its robot. */
  | { kind: "fit" }
  /** Settings of a preset file. */
  | { kind: "preset"; name: string; bytes: ArrayBuffer }
  /** Of a live robot from here on, of a recording when it is opened next. */
  | { kind: "tell"; settings: SettingValues; twin: boolean }
  /** All planners on one query; the tree of one of them is told. */
  | { kind: "contest"; ask: ContestAsk; watched: number }
  | { kind: "contest-watch"; watched: number }
  | { kind: "contest-stop" }
  /** A trial of the simulated robot's drive controller. */
  | { kind: "bench"; trial: BenchTrial }
  /** A robot behind a bridge, at the address of its WebSocket; with an empty token this page only watches. */
  | { kind: "connect"; url: string; token: string; method: MethodName }
  /** Devices at serial ports of the page, whose rules are at the other end of this wire. */
  | { kind: "cable"; wire: MessagePort; method: MethodName }
  /** Leaves them. */
  | { kind: "unplug" }
  /** The right to drive it: takes it (with `force` also from somebody else), or gives it back. */
  | { kind: "wheel"; take: boolean; force: boolean }
  /** Opens or shuts a door of the simulated world, by its number. */
  | { kind: "door"; index: number; open: boolean }
  /** Cuts its motors off, or unlatches that. */
  | { kind: "emergency"; on: boolean }
  /** The grid, the walls as a floor plan, the trajectory, the log, or what was fitted last as a preset. */
  | { kind: "save"; what: SavedKind | "fit" }
  | { kind: "drawn" };

/** `lost` is tried again, `refused` is not. */
export type Connection = "connecting" | "open" | "lost" | "refused";

export interface Device {
  /** As the bridge was told of it: `rplidar:/dev/ttyUSB0`. */
  name: string;
  /** What it is; empty until it said so. */
  model: string;
  /** waiting, connected, measuring, sending or fault. */
  state: string;
  /** Of a fault: cause and cure. */
  detail: string;
}

/** What a bridge and the robot behind it say of themselves. NaN where nothing is known. */
export interface BridgeState {
  connection: Connection;
  /** Why the connection is not open; empty while it is. */
  fault: string;
  mayDrive: boolean;
  hasLease: boolean;
  /** The robot moves on this page's commands. */
  armed: boolean;
  emergency: boolean;
  /** Who has the right to drive; empty for nobody. */
  driver: string;
  /** Why the robot is not armed. */
  reason: string;
  /** V. */
  battery: number;
  /** From here to the bridge and back, and age of the robot's newest reading there, s. */
  roundTrip: number;
  readingAge: number;
  /** Readings that this page missed. */
  dropped: number;
  watchers: number;
  /** File of the recording; empty for none. Messages that stand in it. */
  recording: string;
  recorded: number;
  devices: Device[];
}

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

/** Places of the numbers of each region in `Rooms.regions`: kind 0 for a room and 1 for a corridor, m² and m. */
export const REGION = { kind: 0, area: 1, x: 2, y: 3, width: 4 } as const;
export const REGION_STRIDE = 5;
/** Places of the numbers of each door in `Rooms.doors`: the regions it joins, posts, middle and width in m, and whether both posts were seen. */
export const DOORWAY = { from: 0, to: 1, x1: 2, y1: 3, x2: 4, y2: 5, x: 6, y: 7, width: 8, framed: 9 } as const;
export const DOORWAY_STRIDE = 10;

/** The topological map: rooms, corridors and doors, the largest region first; map frame, m. */
export interface Rooms {
  regions: Float64Array;
  doors: Float64Array;
  /** x y of the corners of all outlines. */
  corners: Float32Array;
  /** Of each outline its region and number of corners. */
  rings: Uint32Array;
}

/** What the filter's figures say; the meaning stands with `Diagnosis` in the core. */
export type DiagnosisName = "collecting" | "blind" | "honest" | "wrong-match" | "hidden-drift" | "noisy-sightings" | "cautious";

/** What became of a line of the scan, in the order of their codes. */
export const VERDICTS = ["matched", "added", "ambiguous", "outside-gate", "taken", "seam", "singular"] as const;
/** Inside which gate a candidate lies, in the order of their codes. */
export const GATES = ["match", "near", "far", "beyond"] as const;
/** Places of the numbers of each line in `Inspection.sightings`; ends in the map frame, m. */
export const SIGHTING = { x1: 0, y1: 1, x2: 2, y2: 3, verdict: 4, landmark: 5, candidates: 6 } as const;
export const SIGHTING_STRIDE = 7;
/** Places of the numbers of each candidate in `Inspection.candidates`; rad and m. */
export const CANDIDATE = { landmark: 0, d2: 1, gap: 2, deltaAlpha: 3, deltaR: 4, sigmaAlpha: 5, sigmaR: 6, gate: 7 } as const;
export const CANDIDATE_STRIDE = 8;

/** Places of what is learned of the odometry: turn in a drive that it takes for straight, rad/m; part by which a turn is larger than
 * it says; and their standard deviations. */
export const ODOMETRY = { curvature: 0, turnScale: 1, curvatureSigma: 2, turnScaleSigma: 3 } as const;

/** The line filter after the last scan. */
export interface Inspection {
  /** Rows of the matrix that belong to the robot; two for each landmark follow, α and r. */
  robotRows: number;
  /** Landmarks in the order of their rows. */
  landmarks: Uint32Array;
  /** Correlation coefficients, row by row, -1 to 1; empty where the matrix was not asked for. */
  coefficients: Float32Array;
  /** Lines of the scan, see SIGHTING. */
  sightings: Float64Array;
  /** What they were compared with, in the same order, see CANDIDATE. */
  candidates: Float64Array;
  /** What the filter learned of its odometry, see ODOMETRY. */
  odometry: Float64Array;
  /** Largest d² of a match, and smallest of a new wall. */
  gate: number;
  newGate: number;
  /** Largest free distance between the seen and the known part of one wall, m. */
  maxGap: number;
}

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

/** What is asked of the motors on the bench. */
export interface BenchTrial {
  /** Wished speed as a part of the robot's highest. */
  forward: number;
  /** Part by which the right motor's magnet is stronger than the controller believes. */
  mismatch: number;
  /** Pull back on the left track, N, and from when on, s. */
  pull: number;
  pullAt: number;
  /** How long, s. */
  seconds: number;
}

/** Its time series, all of one length. */
export interface BenchResponse {
  seconds: Float64Array;
  /** m/s. */
  wished: Float64Array;
  /** Left and right track with the controller, then without, m/s: four series one after the other. */
  speeds: Float64Array;
  /** Heading less the wished one with the controller, then without, rad. */
  headings: Float64Array;
}

export type LogLevel = "info" | "good" | "warn";

/** What can be saved, as the module calls it, and what a person reads. */
export const SAVED = {
  map: "Map for ROS (PGM, YAML)",
  "map-scale": "Map for ROS, probabilities (PNG, YAML)",
  "map-raw": "Map for ROS, raw percentages (PGM, YAML)",
  "og-map": "Map as text (OGmap.txt)",
  plan: "Walls (SVG, DXF, GeoJSON)",
  rooms: "Rooms and doors (GeoJSON)",
  tum: "Way of the robot (TUM)",
  carmen: "Scans and odometry (CARMEN log)",
} as const;
export type SavedKind = keyof typeof SAVED;

export interface SavedFile {
  name: string;
  mime: string;
  bytes: Uint8Array<ArrayBuffer>;
}

export type Answer =
  /** The module is there, with these worlds and sensors. */
  | { kind: "ready"; worlds: string[]; sensors: Named[]; presets: Preset[]; dataSheet: string }
  | { kind: "started"; run: number; source: SourceKind; title: string; method: MethodName; setup: Setup | null; playing: boolean }
  | Frame
  /** A log is being read, so much of it is done (0 to 1); null: no longer. The run before stands still meanwhile. */
  | { kind: "reading"; name: string; done: number | null }
  | { kind: "playing"; playing: boolean }
  /** A building that was asked for, as the text of a world file, and what of the file is not in it. */
  | { kind: "built"; name: string; worldJson: string; leftOut: string[] }
  /** A map to be found in that was asked for. */
  | { kind: "known"; known: KnownMap; leftOut: string[] }
  | { kind: "hash"; run: number; text: string }
  /** What happened; with `alert` it is shown at once, not only in the log. */
  | { kind: "event"; run: number; time: number; level: LogLevel; text: string; topic?: string; alert?: boolean }
  | { kind: "saved"; files: SavedFile[] }
  | { kind: "bench"; response: BenchResponse }
  | { kind: "settings"; settings: Setting[] }
  /** A calibration, or what is wrong with the pairs. */
  | { kind: "calibrated"; calibration: Calibration | null; error: string }
  /** An estimate, or why there is none. */
  | { kind: "sigma"; curve: SigmaCurve | null; error: string }
  /** What a drive told, or why it tells nothing. */
  | { kind: "fit"; fit: DriveFit | null; error: string }
  /** A preset that was opened. */
  | { kind: "preset"; name: string; settings: SettingValues }
  /** How the planners stand, or why they cannot be asked. */
  | { kind: "contest"; contest: ContestState | null; error: string }
  | { kind: "bridge"; state: BridgeState | null }
  /** Something could not be done; the state before stays. */
  | { kind: "failed"; text: string };

/** The arrays of a frame that change hands. */
export function transferables(frame: Frame): ArrayBuffer[] {
  const arrays = [
    frame.grid?.index, frame.grid?.cells, frame.scan, frame.beams, frame.doors, frame.found, frame.lines, frame.truth, frame.materials, frame.known, frame.movers, frame.path, frame.rawPath, frame.tree,
    frame.frontiers, frame.trail, frame.twin, frame.samples, frame.inspection?.landmarks, frame.inspection?.coefficients, frame.inspection?.sightings,
    frame.inspection?.candidates, frame.inspection?.odometry, frame.rooms?.regions, frame.rooms?.doors, frame.rooms?.corners, frame.rooms?.rings,
  ];
  const buffers = new Set<ArrayBuffer>();
  for (const array of arrays) {
    if (array && array.buffer instanceof ArrayBuffer) buffers.add(array.buffer);
  }
  return [...buffers];
}
