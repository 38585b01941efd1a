// Every message between the page and the worker, defined once for both sides.
//
// Page -> worker: `Command`. Worker -> page: `Answer`. Bulk data are transferable typed arrays in a
// `Frame`. There is at most one frame for each picture drawn: the page answers a frame with
// `drawn`, and only then is the next one sent. All geometry, the truth included, is in the map
// frame (m, rad, x forward and y left of the robot's start pose).

import type { BridgeState } from "./protocol/devices.js";
import type { Frame, Renumbering } from "./protocol/frame.js";
import type { BenchResponse, BenchTrial, Building, Calibration, ContestAsk, ContestState, DriveFit, FieldName, Grade, GrowthName, Inspection, PriorMapFile, Quality, Level, MethodName, Offer, Pairs, PresetFile, ReplaySetup, RosTopics, SavedFile, SavedKind, SettingInfo, SettingValues, Setup, SigmaCurve, SourceKind, ErrorKind, EditName, FenceZone, LoadedMapPicture, MapAlignment, MapStart, PathPlace, PosePathPicture, TruthCurve, SavedMapPicture, SolvedGraph, WorldFault } from "./protocol/module.js";

/** A file as it was dropped or chosen. */
export interface GivenBytes {
  name: string;
  bytes: ArrayBuffer;
}

/** The topics of a ROS recording to be mapped; null: the only ones possible. */
export interface Topics {
  scans: string | null;
  odometry: string | null;
}

/** How a live robot is mapped and driven. */
export type LiveSetup = Pick<Setup, "method" | "priorMap" | "cycle" | "settings"> & Pick<ReplaySetup, "twin">;

export type Command =
  | { kind: "start"; setup: Setup; play: boolean }
  /** Repeats the simulated run of a link. */
  | { kind: "follow"; link: string }
  /** Asks for the link of this run, which began with `setup`. Answered by `link`. */
  | { kind: "link"; setup: Setup }
  /** The same for the next visit, or because somebody asked. Answered by `kept`. */
  | { kind: "keep"; setup: Setup; asked?: true }
  /** A building to drive in, from foreign files: a floor plan (.svg), a submap (.smap), an
      OGmap.txt, or the YAML and the image of a ROS map. Answered by `built`. */
  | { kind: "build"; name: string; files: readonly GivenBytes[] }
  /** The same, or a world, as a prior map; without files, the map drawn by the present run.
      Answered by `prior-map`. */
  | { kind: "read-prior-map"; name: string; files: readonly GivenBytes[] }
  /** Asks for a built-in world to edit. Answered by `world-file`. */
  | { kind: "world-file"; world: string }
  /** Asks whether a robot can be in the drawing. Answered by `world-checked`. */
  | { kind: "check-world"; text: string; number: number }
  /** Maps a recorded log. Topics are those of a ROS recording; if it has several and none are
      given, `topics` asks for them. */
  | ({ kind: "replay"; name: string; bytes: ArrayBuffer; topics: Topics | null } & ReplaySetup)
  | { kind: "play" }
  | { kind: "pause" }
  /** Advances to the next scan and pauses. */
  | { kind: "step" }
  /** Goes to a moment, s, earlier or later, and waits there. */
  | { kind: "seek"; time: number }
  /** Goes to the scan before, and waits there. */
  | { kind: "back" }
  /** Simulated seconds per second; Infinity is as fast as possible. */
  | { kind: "speed"; factor: number }
  /** While playing, waits at this moment, s; Infinity: nowhere. Not on the way to a moment that was
      asked for. */
  | { kind: "hold-at"; time: number }
  | { kind: "explore" }
  | { kind: "manual" }
  /** Map frame, m. */
  | { kind: "goto"; x: number; y: number }
  /** Fractions of the robot's highest speeds in [-1, 1], until changed; positive is forward and
      left. */
  | { kind: "drive"; forward: number; turn: number }
  | { kind: "stop" }
  /** Stops reading a log, or ends a replay where it is; the map so far stays. */
  | { kind: "cancel" }
  /** Whether frames contain the filter's state, and whether with the matrix, which is long. */
  | { kind: "inspect"; on: boolean; matrix: boolean }
  /** Whether frames contain rooms and doors. */
  | { kind: "rooms"; on: boolean }
  /** Whether frames contain corners, spikes, crossings and circles of the last scan. */
  | { kind: "points"; on: boolean }
  /** Whether frames contain the map drawn by odometry alone. */
  | { kind: "wheels"; on: boolean }
  /** Which field of the grid frames contain; null: none. */
  | { kind: "field"; name: FieldName | null }
  /** Drive by the cycle, or continuously. */
  | { kind: "cycle"; on: boolean }
  /** Goes on to the end of the next stage of the cycle and pauses. */
  | { kind: "stage" }
  /** All settings that differ from their defaults, for any source; those that can act at once
      do. */
  | { kind: "configure"; settings: SettingValues }
  /** Asks what is known of a cell of the grid, map frame, m; with `wall` also why lines were
      matched. Answered by `examined`, with the same number. */
  | { kind: "examine"; number: number } & Question
  /** Asks for all settings of this run, with these changes. */
  | { kind: "settings"; settings: SettingValues }
  | { kind: "calibrate"; pairs: Pairs }
  /** Estimates σ(ρ) from scans taken standing: those of a log, or of a simulated robot that
      stands. */
  | { kind: "sigma"; growth: GrowthName }
  /** Estimates the robot's parameters from the drive so far. */
  | { kind: "fit" }
  /** Asks for a judgement of the map. */
  | { kind: "quality" }
  /** Settings of a preset file. */
  | { kind: "preset"; name: string; bytes: ArrayBuffer }
  /** Runs a simulated twin beside a live or recorded robot from here on, or stops it. */
  | { kind: "twin"; on: boolean }
  /** Runs all planners on one query; the tree of the watched one is sent. */
  | { kind: "contest"; ask: ContestAsk; watched: number }
  | { kind: "contest-watch"; watched: number }
  | { kind: "contest-stop" }
  /** A trial of the simulated robot's drive controller. */
  | { kind: "bench"; trial: BenchTrial }
  /** Connects to a robot behind a bridge, at the address of its WebSocket; with an empty token this
      page only watches. */
  | ({ kind: "connect"; url: string; token: string } & LiveSetup)
  /** Uses devices at serial ports of the page; the other end of this wire holds their rules. */
  | ({ kind: "cable"; wire: MessagePort } & LiveSetup)
  /** Disconnects from the robot. */
  | { kind: "unplug" }
  /** Takes the right to drive (with `force` also from another client), or returns it. */
  | { kind: "lease"; take: boolean; force: boolean }
  /** Opens or shuts a door of the simulated world, by its number. */
  | { kind: "door"; index: number; open: boolean }
  /** Carries the simulated robot to a random place; it does not notice. */
  | { kind: "kidnap" }
  /** Cuts the power of the robot's motors, or restores it. */
  | { kind: "emergency"; on: boolean }
  /** Restarts the bridge's own map. */
  | { kind: "reset-bridge-map" }
  /** Sets where in the bridge's own map the robot may be; without zones, everywhere. */
  | { kind: "set-geofence"; zones: FenceZone[] }
  /** Saves the grid, the walls as a floor plan, the trajectory, the log, the last fit as a preset,
      or the saved map that runs go on in. */
  | { kind: "save"; what: "fit" | "saved-map" }
  /** Asks for the files of a kind, for the list of what can be saved. Answered by `collected`, in
      order. */
  | { kind: "collect"; what: SavedKind }
  /** Runs by scan matching go on in this saved map from the next run on; without bytes they begin
      with an empty map. */
  | { kind: "go-on"; name: string; bytes: ArrayBuffer | null }
  /** Merges a saved map into the present map, drawn or saved. Answered by `going-on`. */
  | { kind: "merge-map"; name: string; bytes: ArrayBuffer }
  /** Prunes the present map: removes what newer parts of it cover. Answered by `going-on`. */
  | { kind: "prune-map" }
  /** Loads a submap (.smap) or a saved map (.slamlab) beside the run, and aligns it with the run's
      map if possible. Answered by `map-loaded` and `map-aligned`. */
  | { kind: "load-map"; name: string; bytes: ArrayBuffer }
  /** Loads poses over time, as a path beside the run. Answered by the same. */
  | { kind: "load-path"; name: string; bytes: ArrayBuffer }
  /** Aligns a loaded map again. Answered by `map-aligned`. */
  | { kind: "align-map"; id: number }
  | { kind: "drop-map"; id: number }
  /** Removes a submap from the map; the run pauses, so that it can be put back. */
  | { kind: "remove-submap"; submap: number }
  /** Puts back the submap that was removed last. */
  | { kind: "undo-removal" }
  /** Saves one submap as a file (.smap). */
  | { kind: "save-submap"; submap: number }
  /** Solves a pose graph (.g2o). Answered by `solved-graph`. */
  | { kind: "solve-graph"; name: string; bytes: ArrayBuffer }
  /** Where in the saved map the robot is when the next run begins. */
  | { kind: "begin-at"; start: MapStart }
  /** Edits the map: x y of corners, map frame, m. */
  | { kind: "edit"; what: EditName; corners: readonly number[] }
  /** Undoes the last edit. */
  | { kind: "undo-edit" }
  | { kind: "drawn" };

/** What a run knows of something that somebody points at, at a time of the run, s: see CELL; for a
    wall also the filter's matching. */
export interface Examined {
  readonly run: number;
  readonly number: number;
  readonly time: number;
  /** See EXAMINED_BEAM; null if none was asked for or it hit nothing. */
  readonly beam: Float64Array | null;
  /** See LEAF; null if none was asked for. */
  readonly leaf: Float64Array | null;
  readonly cell: Float64Array;
  readonly inspection: Inspection | null;
}

/** A question to a run: about the cell at a place, and optionally more. */
export interface Question {
  readonly x: number;
  readonly y: number;
  /** Whether to tell also why lines were matched. */
  readonly wall?: boolean;
  /** Index of a beam of the last scan. */
  readonly beam?: number;
  /** The posts of a gap, x1 y1 x2 y2, map frame, m. */
  readonly leaf?: readonly number[];
}

/** A handler for each kind of message. */
export type Handlers<Message extends { kind: string }> = { readonly [Kind in Message["kind"]]: (message: Extract<Message, { kind: Kind }>) => void };

/** Passes a message to the handler of its kind. */
export function handle<Message extends { kind: string }>(handlers: Handlers<Message>, message: Message): void {
  const handler = handlers[message.kind as Message["kind"]] as (message: Message) => void;
  handler(message);
}

export type Answer =
  /** The module is loaded, and these are the choices. */
  | ({ kind: "ready" } & Offer)
  | { kind: "started"; run: number; source: SourceKind; title: string; method: MethodName; setup: Setup | null; playing: boolean; isAgain: boolean }
  | Frame
  /** Progress in reading a log (0 to 1); null: no longer reading. Meanwhile the run before stands
      still. */
  | { kind: "reading"; name: string; done: number | null }
  /** A ROS recording has several topics of a kind. It has to be opened again with the chosen
      ones. */
  | { kind: "topics"; name: string; offered: RosTopics }
  | { kind: "playing"; playing: boolean }
  /** The requested building, as the text of a world file, and what of the file was left out. */
  | ({ kind: "built"; name: string } & Building)
  /** A built-in world as the text of a world file. */
  | { kind: "world-file"; world: string; text: string }
  /** The error in the drawing of this number; null: none. */
  | { kind: "world-checked"; number: number; fault: WorldFault | null }
  /** The requested prior map. */
  | ({ kind: "prior-map" } & PriorMapFile)
  /** The saved map that runs go on in from here on (none if the name is empty), whether a run is to
      begin in it now, and what was done, in words. */
  | { kind: "going-on"; name: string; picture: SavedMapPicture | null; begins: boolean; told: string }
  /** A map that was loaded, or a path of poses, which has no walls. */
  | { kind: "map-loaded"; id: number; name: string; picture: LoadedMapPicture; path: Omit<PosePathPicture, "way"> | null }
  /** Where it lies in the map of this run, or why that is not known. */
  | { kind: "map-aligned"; id: number; alignment: MapAlignment | PathPlace | null; error: string }
  /** For a recording mapped to its end: the errors of the whole trajectory against true poses. */
  | { kind: "truth-errors"; run: number; errors: TruthCurve }
  /** A submap was removed from the map (-1), put back (1), or neither was possible (0). */
  | ({ kind: "renumbered" } & Renumbering)
  /** A pose graph, solved. */
  | { kind: "solved-graph"; name: string; graph: SolvedGraph }
  | { kind: "hash"; run: number; text: string }
  /** Something happened; with `alert` it is shown at once, not only in the log. */
  | { kind: "event"; run: number; time: number; level: Level; text: string; topic?: string; alert?: boolean }
  | { kind: "saved"; files: SavedFile[] }
  /** The answer to `collect`; without files, why there are none. */
  | { kind: "collected"; files: SavedFile[]; error: string }
  | ({ kind: "examined" } & Examined)
  | { kind: "bench"; response: BenchResponse }
  | { kind: "settings"; settings: SettingInfo[] }
  /** A repeated run has reached the moment at which the settings were changed. */
  | { kind: "followed-settings"; run: number; settings: SettingValues }
  /** A calibration, or what is wrong with the pairs. */
  | { kind: "calibrated"; calibration: Calibration | null; error: string }
  /** An estimate, or why there is none. */
  | { kind: "sigma"; curve: SigmaCurve | null; error: string }
  /** The fit of a drive, or why there is none. */
  | { kind: "fit"; fit: DriveFit | null; error: string }
  /** The part of the map that has been judged, 0 to 1. */
  | { kind: "judging"; run: number; part: number }
  /** The judgement of the map; null if the method allows none. */
  | { kind: "quality"; run: number; quality: Quality | null }
  /** The grade of the present attempt at a lesson. */
  | { kind: "grade"; run: number; grade: Grade | null }
  /** A preset that was opened. */
  | ({ kind: "preset" } & PresetFile)
  /** The state of the planners, or why they cannot be run. */
  | { kind: "contest"; contest: ContestState | null; running: boolean; error: string }
  /** Null walls: unchanged. */
  | { kind: "bridge"; state: BridgeState | null; walls: Float32Array | null }
  /** The link is `null` if no link can describe what was done. */
  | { kind: "kept"; link: string | null; asked: boolean }
  /** The part of this run's address from the `#` on. */
  | { kind: "link"; link: string }
  /** Something failed; the state before stays. `isBroken`: this worker is of no more use. */
  | { kind: "failed"; about: ErrorKind; text: string; isBroken: boolean };
