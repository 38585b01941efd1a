// Every message between the page and the worker, named once for both sides.
//
// Page -> worker: `Command`. Worker -> page: `Answer`. Bulk data crosses as transferable typed
// arrays inside of `Frame`, at most one frame for each picture drawn: the page answers a frame with
// `drawn`, and only then the next one is sent. All geometry is in the map frame (m, rad, x forward
// and y left of the robot's start pose), also the truth.

import type { BridgeState } from "./protocol/devices.js";
import type { Frame, Renumbering } from "./protocol/frame.js";
import type { BenchResponse, BenchTrial, Building, Calibration, ContestAsk, ContestState, DriveFit, FieldName, Grade, GrowthName, Inspection, PriorMapFile, Quality, Level, MethodName, Offer, Pairs, PresetFile, ReplaySetup, RosTopics, SavedFile, SavedKind, SettingInfo, SettingValues, Setup, SigmaCurve, SourceKind, ErrorKind, EditName, FenceZone, LoadedMapPicture, MapAlignment, MapStart, SavedMapPicture, SolvedGraph, WorldFault } from "./protocol/module.js";

/** A file as it was dropped or chosen. */
export interface GivenBytes {
  name: string;
  bytes: ArrayBuffer;
}

/** What of a recording of ROS is mapped; null: what can only be meant. */
export interface Topics {
  scans: string | null;
  odometry: string | null;
}

/** How a live robot is mapped and driven. */
export type LiveSetup = Pick<Setup, "method" | "priorMap" | "cycle" | "settings"> & Pick<ReplaySetup, "twin">;

export type Command =
  | { kind: "start"; setup: Setup; play: boolean }
  /** The simulated run of a link. */
  | { kind: "follow"; link: string }
  /** Asks for the link of this run, which began with `setup`; it is answered by `link`. */
  | { kind: "link"; setup: Setup }
  /** The same for the next visit, or where somebody asked; it is answered by `kept`. */
  | { kind: "keep"; setup: Setup; asked?: true }
  /** A building to drive in from files of others: a floor plan (.svg), a submap (.smap),
      OGmap.txt, or the YAML and the image of a map of ROS. It is answered by `built`. */
  | { kind: "build"; name: string; files: readonly GivenBytes[] }
  /** The same, or a world, as a map to be found in; without files the map as the present run has
      drawn it. It is answered by `prior-map`. */
  | { kind: "read-prior-map"; name: string; files: readonly GivenBytes[] }
  /** A built-in world to be drawn on. It is answered by `world-file`. */
  | { kind: "world-file"; world: string }
  /** Whether a robot can be in what was drawn. It is answered by `world-checked`. */
  | { kind: "check-world"; text: string; number: number }
  /** A recorded log. Topics are those of a recording of ROS; without them they are asked for by
      `topics` where it has several. */
  | ({ kind: "replay"; name: string; bytes: ArrayBuffer; topics: Topics | null } & ReplaySetup)
  | { kind: "play" }
  | { kind: "pause" }
  /** Advances to the next scan and pauses. */
  | { kind: "step" }
  /** To a moment, s, earlier or later, and waits there. */
  | { kind: "seek"; time: number }
  /** To the scan before, and waits there. */
  | { kind: "back" }
  /** Simulated seconds for each second; Infinity is as fast as it goes. */
  | { kind: "speed"; factor: number }
  /** Waits where it comes to this moment, s, as long as it plays; Infinity: nowhere. On the way to
      a moment that was asked for it does not. */
  | { kind: "hold-at"; time: number }
  | { kind: "explore" }
  | { kind: "manual" }
  /** Map frame, m. */
  | { kind: "goto"; x: number; y: number }
  /** Fractions of the robot's highest speeds in [-1, 1], until changed; forward and to the left. */
  | { kind: "drive"; forward: number; turn: number }
  | { kind: "stop" }
  /** Ends reading a log, and a replay where it stands; what was mapped stays. */
  | { kind: "cancel" }
  /** Whether frames carry what goes on inside the filter, and whether with the matrix, which is
      long. */
  | { kind: "inspect"; on: boolean; matrix: boolean }
  /** Whether frames carry rooms and doors. */
  | { kind: "rooms"; on: boolean }
  /** Whether frames carry corners, spikes, crossings and circles of the last scan. */
  | { kind: "points"; on: boolean }
  /** Whether frames carry the map that the wheels alone would have drawn. */
  | { kind: "wheels"; on: boolean }
  /** Which field of the grid frames carry; null: none. */
  | { kind: "field"; name: FieldName | null }
  /** Drive by the cycle, or continuously. */
  | { kind: "cycle"; on: boolean }
  /** Goes on to the end of the next stage of the cycle and pauses. */
  | { kind: "stage" }
  /** All settings that differ from their defaults, of every source: those that act at once do. */
  | { kind: "configure"; settings: SettingValues }
  /** Asks what is known of a cell of the grid, map frame, m; with `wall` also why lines were
      matched. It is answered by `examined`, with the same number. */
  | { kind: "examine"; number: number } & Question
  /** Asks for all settings of this run, with these changes. */
  | { kind: "settings"; settings: SettingValues }
  | { kind: "calibrate"; pairs: Pairs }
  /** σ(ρ) from a log's scans taken standing, or from those of a simulated robot that stands. */
  | { kind: "sigma"; growth: GrowthName }
  /** Estimates the robot's parameters from the drive so far. */
  | { kind: "fit" }
  /** Asks what the map is worth. */
  | { kind: "quality" }
  /** Settings of a preset file. */
  | { kind: "preset"; name: string; bytes: ArrayBuffer }
  /** A simulated twin beside a live or a recorded robot from here on, or none. */
  | { kind: "twin"; on: boolean }
  /** All planners on one query; the tree of the watched one is sent. */
  | { kind: "contest"; ask: ContestAsk; watched: number }
  | { kind: "contest-watch"; watched: number }
  | { kind: "contest-stop" }
  /** A trial of the simulated robot's drive controller. */
  | { kind: "bench"; trial: BenchTrial }
  /** A robot behind a bridge, at the address of its WebSocket; with an empty token this page only
      watches. */
  | ({ kind: "connect"; url: string; token: string } & LiveSetup)
  /** Devices at serial ports of the page, whose rules are at the other end of this wire. */
  | ({ kind: "cable"; wire: MessagePort } & LiveSetup)
  /** Leaves them. */
  | { kind: "unplug" }
  /** Takes the right to drive (with `force` also from another client), or gives it back. */
  | { kind: "lease"; take: boolean; force: boolean }
  /** Opens or shuts a door of the simulated world, by its number. */
  | { kind: "door"; index: number; open: boolean }
  /** Carries the simulated robot to a random place; it does not notice. */
  | { kind: "kidnap" }
  /** Cuts its motors off, or unlatches that. */
  | { kind: "emergency"; on: boolean }
  /** Has the bridge begin its own map anew. */
  | { kind: "reset-bridge-map" }
  /** Says where in the bridge's own map the robot may be; without zones, everywhere. */
  | { kind: "set-geofence"; zones: FenceZone[] }
  /** The grid, the walls as a floor plan, the trajectory, the log, what was fitted last as a
      preset, or the saved map that runs go on in. */
  | { kind: "save"; what: "fit" | "saved-map" }
  /** The files of a kind for the list of what can be saved. It is answered by `collected`, in
      turn. */
  | { kind: "collect"; what: SavedKind }
  /** Runs by scan matching go on in this saved map from the next one on; without bytes in none. */
  | { kind: "go-on"; name: string; bytes: ArrayBuffer | null }
  /** Joins a saved map to the one that there is, drawn or saved. It is answered by `going-on`. */
  | { kind: "merge-map"; name: string; bytes: ArrayBuffer }
  /** Takes out of the map that there is what newer parts of it cover. It is answered by
      `going-on`. */
  | { kind: "prune-map" }
  /** A submap (.smap) or a saved map (.slamlab) to be looked at beside the run, and laid on its map
      if it is found where. It is answered by `map-loaded` and `map-aligned`. */
  | { kind: "load-map"; name: string; bytes: ArrayBuffer }
  /** Looks again where a loaded map lies. It is answered by `map-aligned`. */
  | { kind: "align-map"; id: number }
  | { kind: "drop-map"; id: number }
  /** Takes a submap out of the map; the run pauses, so that it can be put back. */
  | { kind: "remove-submap"; submap: number }
  /** Puts back the one that was taken out last. */
  | { kind: "undo-removal" }
  /** One submap as a file (.smap). */
  | { kind: "save-submap"; submap: number }
  /** A pose graph (.g2o) to be solved. It is answered by `solved-graph`. */
  | { kind: "solve-graph"; name: string; bytes: ArrayBuffer }
  /** Where the robot is in it when the next run begins. */
  | { kind: "begin-at"; start: MapStart }
  /** Changes the map by hand: x y of corners, map frame, m. */
  | { kind: "edit"; what: EditName; corners: readonly number[] }
  /** Takes the last change back. */
  | { kind: "undo-edit" }
  | { kind: "drawn" };

/** What a run says of what somebody points at, at a time of the run, s: see CELL, and of a wall
    what went on in the filter. */
export interface Examined {
  readonly run: number;
  readonly number: number;
  readonly time: number;
  /** See EXAMINED_BEAM; null where none was asked for or it hit nothing. */
  readonly beam: Float64Array | null;
  /** See LEAF; null where none was asked for. */
  readonly leaf: Float64Array | null;
  readonly cell: Float64Array;
  readonly inspection: Inspection | null;
}

/** What is asked of a run: a cell by a place in it, and what else. */
export interface Question {
  readonly x: number;
  readonly y: number;
  /** Whether also why lines were matched. */
  readonly wall?: boolean;
  /** A beam of the last scan by its number. */
  readonly beam?: number;
  /** The posts of a gap, x1 y1 x2 y2, map frame, m. */
  readonly leaf?: readonly number[];
}

/** What is done about each kind of message. */
export type Handlers<Message extends { kind: string }> = { readonly [Kind in Message["kind"]]: (message: Extract<Message, { kind: Kind }>) => void };

/** Hands a message to the handler of its kind. */
export function handle<Message extends { kind: string }>(handlers: Handlers<Message>, message: Message): void {
  const handler = handlers[message.kind as Message["kind"]] as (message: Message) => void;
  handler(message);
}

export type Answer =
  /** The module is there, and this can be chosen. */
  | ({ kind: "ready" } & Offer)
  | { kind: "started"; run: number; source: SourceKind; title: string; method: MethodName; setup: Setup | null; playing: boolean; isAgain: boolean }
  | Frame
  /** A log is being read, so much of it is done (0 to 1); null: no longer. The run before stands
      still meanwhile. */
  | { kind: "reading"; name: string; done: number | null }
  /** A recording of ROS has several of a kind: which are meant? It is to be opened again with
      them. */
  | { kind: "topics"; name: string; offered: RosTopics }
  | { kind: "playing"; playing: boolean }
  /** A building that was asked for, as the text of a world file, and what of the file is not in
      it. */
  | ({ kind: "built"; name: string } & Building)
  /** A built-in world as the text of a world file. */
  | { kind: "world-file"; world: string; text: string }
  /** What is wrong with the drawing of this number; null: nothing. */
  | { kind: "world-checked"; number: number; fault: WorldFault | null }
  /** A map to be found in that was asked for. */
  | ({ kind: "prior-map" } & PriorMapFile)
  /** The saved map that runs go on in from here on, none where the name is empty; whether one is to
      begin in it now; and what was done, in words. */
  | { kind: "going-on"; name: string; picture: SavedMapPicture | null; begins: boolean; told: string }
  /** A map that was loaded. */
  | { kind: "map-loaded"; id: number; name: string; picture: LoadedMapPicture }
  /** Where it lies in the map of this run, or why that is not known. */
  | { kind: "map-aligned"; id: number; alignment: MapAlignment | null; error: string }
  /** A submap was taken out of the map (-1), put back (1), or could not be (0). */
  | ({ kind: "renumbered" } & Renumbering)
  /** A pose graph, solved. */
  | { kind: "solved-graph"; name: string; graph: SolvedGraph }
  | { kind: "hash"; run: number; text: string }
  /** What happened; with `alert` it is shown at once, not only in the log. */
  | { kind: "event"; run: number; time: number; level: Level; text: string; topic?: string; alert?: boolean }
  | { kind: "saved"; files: SavedFile[] }
  /** What was asked for by `collect`; without files, why there are none. */
  | { kind: "collected"; files: SavedFile[]; error: string }
  | ({ kind: "examined" } & Examined)
  | { kind: "bench"; response: BenchResponse }
  | { kind: "settings"; settings: SettingInfo[] }
  /** A run that does again what was done before has come to where the settings were changed. */
  | { kind: "followed-settings"; run: number; settings: SettingValues }
  /** A calibration, or what is wrong with the pairs. */
  | { kind: "calibrated"; calibration: Calibration | null; error: string }
  /** An estimate, or why there is none. */
  | { kind: "sigma"; curve: SigmaCurve | null; error: string }
  /** The fit of a drive, or why there is none. */
  | { kind: "fit"; fit: DriveFit | null; error: string }
  /** The part of the map that is judged, 0 to 1. */
  | { kind: "judging"; run: number; part: number }
  /** What the map is worth; null where the method cannot tell. */
  | { kind: "quality"; run: number; quality: Quality | null }
  /** What a try at a lesson has reached. */
  | { kind: "grade"; run: number; grade: Grade | null }
  /** A preset that was opened. */
  | ({ kind: "preset" } & PresetFile)
  /** How the planners stand, or why they cannot be asked. */
  | { kind: "contest"; contest: ContestState | null; running: boolean; error: string }
  /** Null walls: they are the same as before. */
  | { kind: "bridge"; state: BridgeState | null; walls: Float32Array | null }
  /** Something could not be done; the state before stays. */
  /** What stands behind the `#` of the address of this run. */
  /** `null` where no link can tell what was done. */
  | { kind: "kept"; link: string | null; asked: boolean }
  | { kind: "link"; link: string }
  /** `isBroken`: and nothing more can be done by this worker. */
  | { kind: "failed"; about: ErrorKind; text: string; isBroken: boolean };
