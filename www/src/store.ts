// The state of the page, and its listeners. Components read it and send commands; nothing is
// computed here.

import { type Grade, type BenchResponse, type Calibration, type ContestState, type Cycle, type EditName, type DriveFit, type Ground, type Inspection, type LoadedMapPicture, type MapAlignment, type MapStart, type PathPlace, type PosePathPicture, type MethodName, type Quality, type Rooms, type RosTopics, type SavedMapPicture, type Setup, type SolvedGraph, type SigmaCurve, type SourceKind, TWIN_STRIDE, type Level } from "./protocol/module.js";
import type { Tuning } from "./protocol/setup.js";
import type { Examined } from "./protocol.js";
import type { BridgeState } from "./protocol/devices.js";
import type { Offer, SettingInfo } from "./protocol/module.js";
import type { Frame, Status } from "./protocol/frame.js";
import { LAYERS, type LayerName } from "./view/scene.js";
import type { Outline } from "./view/layers/layer.js";
import type { Thing } from "./view/things.js";
import type { GridView } from "./view/tiles.js";
import type { Host } from "./bridge_address.js";
import type { FenceDraft } from "./fence.js";
import type { GamepadState } from "./gamepad.js";
import type { LastRun } from "./last_run.js";
import { History } from "./history.js";
import type { Offline, Renewal } from "./offline.js";
import { type LogEntry, withEntry } from "./log.js";
import { type Mark, marked } from "./past.js";
import type { Shown } from "./gallery.js";
import type { Compared } from "./compared.js";
import { numbered } from "./room_numbers.js";
import type { TourStep } from "./tour.js";

export type Theme = "system" | "light" | "dark";
export const TABS = ["run", "status", "plots", "filter", "paths", "settings", "layers", "log"] as const;
/** Empty if none was chosen, or it was closed again. */
export type Tab = (typeof TABS)[number] | "";

/** `frame` is notified at most ten times a second, the others at once. */
export type Topic = "frame" | "run" | "view" | "log" | "toast" | "tab" | "theme" | "inspection" | "spot" | "bench" | "cycle" | "settings" | "calibration" | "sigma" | "bridge" | "doors" | "contest" | "fit" | "rooms" | "chosen" | "moved" | "quality" | "graph" | "submaps" | "tour" | "exhibit" | "lesson" | "last" | "offline" | "gamepad" | "drawing";

/** Walls highlighted on the map, in the matrix and in the list of matches. */
export interface Spot {
  /** Under the pointer, in any view. */
  readonly hovered: readonly number[];
  /** Chosen by a click, until another is. */
  readonly pinned: number | null;
}

/** A contest of planners: its query and its state. */
export interface Contest {
  readonly ground: Ground;
  readonly seconds: number;
  /** Map frame, m; null: at the robot, or not yet chosen. */
  readonly start: readonly [number, number] | null;
  readonly goal: readonly [number, number] | null;
  /** What the next click on the map sets. */
  readonly picking: "start" | "goal";
  readonly watched: number;
  readonly found: ContestState | null;
  readonly running: boolean;
  readonly error: string;
}

export interface Toast {
  level: Level;
  text: string;
  topic?: string;
  /** An action that the message offers. */
  way?: { readonly label: string; readonly go: () => void };
  /** How long it is shown, wall milliseconds, unless it is closed; by default its level decides. */
  stands?: number;
}

/** A map that runs go on in, and where in it the robot begins. */
export interface SavedMap {
  readonly name: string;
  readonly picture: SavedMapPicture;
  readonly start: MapStart;
  /** Whether the present run began in it. */
  readonly isBegun: boolean;
}

/** A map, or a path of poses, that was loaded beside the run. */
export interface LoadedMap {
  readonly id: number;
  readonly name: string;
  readonly picture: LoadedMapPicture;
  /** Whether it is drawn. */
  readonly shown: boolean;
  /** Where it lies in the map of this run; null while unknown: see `error`. */
  readonly alignment: MapAlignment | PathPlace | null;
  /** Only for poses over time, which consist of a path alone. */
  readonly path: Omit<PosePathPicture, "way"> | null;
  readonly error: string;
  /** Whether it is being aligned. */
  readonly isAligning: boolean;
}

/** What the worker sends when a run begins. */
export type RunStart = Pick<Store, "source" | "title" | "playing" | "method"> & { setup: Setup | null; isAgain: boolean };

export class Store {
  status: Status | null = null;
  hash = "";
  seq = 0;
  source: SourceKind = "sim";
  title = "";
  playing = false;
  /** A log that is being read, and the part that is done (0 to 1). */
  reading: { name: string; done: number } | null = null;
  /** A ROS recording with several topics of a kind, until they are chosen. */
  asked: { name: string; offered: RosTopics } | null = null;
  /** Poses that were given, until it is known what they are; without a log they are beside the
      shown one. */
  posesAsked: { poses: File; log: File | null } | null = null;
  /** The saved map that runs by scan matching go on in. */
  savedMap: SavedMap | null = null;
  /** The last pose graph that was opened. */
  solvedGraph: { readonly name: string; readonly graph: SolvedGraph } | null = null;
  /** The edit that a press on the map makes; null while it moves the view. */
  editing: EditName | null = null;
  /** The geofence that is being drawn. */
  fence: FenceDraft | null = null;
  /** World that is being loaded; empty when none is. */
  loading = "";
  speed = 4;
  /** The possible choices; empty until the module is loaded. */
  offer: Offer = { worlds: [], sensors: [], methods: [], devices: [], presets: [], lessons: [], dataSheet: "" };
  setup: Setup = { world: "office", worldJson: null, sensor: "lidar", seed: 7, method: "line-ekf", mode: "explore", cycle: false, settings: {}, calibration: null, priorMap: null, lesson: null };
  /** The setup of the present run's start: settings that wait for a restart differ. */
  started: Setup = this.setup;
  /** All settings, with their values in this run. */
  settings: SettingInfo[] = [];
  calibration: { fit: Calibration | null; error: string } = { fit: null, error: "" };
  sigma: { curve: SigmaCurve | null; error: string } = { curve: null, error: "" };
  /** The fit of the drive, and which part of it is in use. */
  fit: { fit: DriveFit | null; error: string } = { fit: null, error: "" };
  tuning: Tuning = { preset: null, twin: false };
  /** Samples of the twin. */
  readonly twin = new History(TWIN_STRIDE);
  /** Doors of the simulated world, see DOOR. */
  doors: Float32Array = new Float32Array(0);
  /** What serves this page; null while unknown. */
  host: Host | null = null;
  /** The state of the connected bridge. */
  bridge: BridgeState | null = null;
  /** The walls of the bridge's own map, in its frame. */
  bridgeWalls: Float32Array = new Float32Array(0);
  /** Whether the robot drives by the cycle, and the results of its stages. */
  inCycle = false;
  cycle: Cycle | null = null;
  /** The method of the present run. */
  method: MethodName = this.setup.method;
  /** Go to was pressed: the next click on the map sets the goal. */
  aiming = false;
  /** Stop was pressed, and the robot got no other command since. */
  isStopped = false;
  /** The furthest time of the run, or of the run that it repeats, s. */
  furthest = 0;
  /** Marked events up to there. */
  marks: readonly Mark[] = [];
  /** The moment that it is on the way to, s. */
  seeking: number | null = null;
  follow = false;
  gridView: GridView = "continuous";
  layers: Record<LayerName, boolean> = Object.fromEntries(
    LAYERS.map((name) => [name, !["tree", "rawPath", "found", "points", "landmarks", "rooms", "submaps", "graph", "wheels"].includes(name)]),
  ) as Record<LayerName, boolean>;
  /** Layers from the bottom up. */
  layerOrder: readonly LayerName[] = LAYERS;
  /** What draws the map, and why not WebGL2. */
  drawing: { readonly with: "canvas" | "webgl2"; readonly why: string } = { with: "canvas", why: "" };
  /** Whether the page opens without its server, and whether a newer build of it exists. */
  offline: Offline = { kind: "storing" };
  renewal: Renewal = null;
  theme: Theme = "system";
  tab: Tab = "";
  /** The filter's state, while its tab is open. */
  inspection: Inspection | null = null;
  spot: Spot = { hovered: [], pinned: null };
  /** The response of the drive controller on the bench. */
  bench: BenchResponse | null = null;
  contest: Contest = { ground: "truth", seconds: 1, start: null, goal: null, picking: "goal", watched: 3, found: null, running: false, error: "" };
  /** Rooms and doors, while their layer is on, and a place in the chosen one, m. */
  rooms: Rooms | null = null;
  /** The number of each room, from 1; it stays the same while the map grows. */
  roomNumbers: readonly number[] = [];
  roomSpot: readonly [number, number] | null = null;
  /** Whether a click on the map only inspects what is there. */
  inspecting = false;
  /** The things where somebody pointed at the map, and which of them is described. */
  chosen: { readonly things: readonly Thing[]; readonly at: number } | null = null;
  /** The run's answer about it, if there is one. */
  examined: Examined | null = null;
  /** Its outline on the map, m. */
  outline: Outline = [];
  /** Submaps that are not drawn, the one chosen in their list, and those that can be put back, in
      order of removal. */
  hiddenSubmaps: ReadonlySet<number> = new Set();
  chosenSubmap: number | null = null;
  /** Loaded maps, in order of loading. */
  loadedMaps: readonly LoadedMap[] = [];
  /** What other methods made of the recording that is shown. */
  compared: readonly Compared[] = [];
  /** How far the last loop closure moved the map, m. */
  moved = 0;
  /** The last judgement of the map. */
  quality: Quality | null = null;
  /** The run left on the last visit, while it is offered. */
  lastRun: LastRun | null = null;
  /** The grade of this attempt at a lesson. */
  grade: Grade | null = null;
  /** Progress of the judgement of the map, 0 to 1. */
  judging: number | null = null;
  /** The step of the tour; null outside of one. */
  tour: TourStep | null = null;
  /** The experiment of the gallery that is shown. */
  exhibit: Shown | null = null;
  /** The connected gamepad, and its state. */
  gamepad: GamepadState | null = null;
  log: readonly LogEntry[] = [];
  toast: Toast | null = null;
  readonly history = new History();

  #listeners = new Map<Topic, readonly (() => void)[]>();
  #notifiedAt = -Infinity;

  on(topic: Topic, listener: () => void): void {
    this.#listeners.set(topic, [...(this.#listeners.get(topic) ?? []), listener]);
  }

  notify(topic: Topic): void {
    for (const listener of this.#listeners.get(topic) ?? []) listener();
  }

  set<K extends keyof Store>(topic: Topic, patch: Pick<Store, K>): void {
    Object.assign(this, patch);
    this.notify(topic);
  }

  /** Whether the planners are compared: a click on the map then sets their start or goal. */
  get comparesPaths(): boolean {
    return this.tab === "paths";
  }

  /** Whether the shown robot is out of contact. */
  get isCutOff(): boolean {
    return this.source === "bridge" && this.bridge?.connection !== "open";
  }

  /** A run begins: resets what was shown of the one before. */
  begin({ source, title, playing, method, setup, isAgain }: RunStart): void {
    if (!isAgain) [this.furthest, this.marks, this.seeking] = [0, [], null];
    this.history.clear();
    this.twin.clear();
    const ended: Partial<Store> = {
      inspection: null, cycle: null, doors: new Float32Array(0), sigma: { curve: null, error: "" }, spot: { hovered: [], pinned: null },
      hiddenSubmaps: new Set(), chosenSubmap: null,
      loadedMaps: this.loadedMaps.map((map) => ({ ...map, alignment: null, error: "", isAligning: false })),
      rooms: null, roomSpot: null, chosen: null, examined: null, outline: [], moved: 0, quality: null, judging: null, grade: null, log: [], status: null, hash: "", toast: null,
    };
    Object.assign(this, ended);
    // If a recording is mapped again with its own fit, the table of the fit stays.
    if (source !== this.source || title !== this.title) this.fit = { fit: null, error: "" };
    // Places of the old map mean nothing in the new one. Only a simulation knows true walls.
    const ground = source !== "sim" && this.contest.ground === "truth" ? "map" : this.contest.ground;
    this.contest = { ...this.contest, start: null, goal: null, picking: "goal", found: null, running: false, error: "", ground };
    const isBegun = method === "scan-matching";
    const savedMap = this.savedMap && { ...this.savedMap, isBegun };
    this.started = { ...(setup ?? this.setup) };
    this.set("run", { savedMap, source, title, playing, method, setup: setup ?? this.setup, aiming: false, isStopped: false, editing: null, fence: null, loading: "" });
    for (const topic of ["toast", "log", "inspection", "cycle", "doors", "sigma", "fit", "contest", "rooms", "chosen", "moved", "quality", "submaps", "lesson"] as const) this.notify(topic);
  }

  take(frame: Frame): void {
    const before = this.status;
    this.status = frame.status;
    if (frame.status.byHand > (before?.byHand ?? 0)) this.#fork();
    this.furthest = Math.max(this.furthest, frame.status.time);
    this.seq = frame.seq;
    if (frame.samples) this.history.append(frame.samples);
    if (frame.twinReset) this.twin.clear();
    if (frame.twin) this.twin.append(frame.twin);
    if (frame.inspection) this.set("inspection", { inspection: withMatrix(frame.inspection, this.inspection) });
    if (frame.rooms) this.set("rooms", { rooms: frame.rooms, roomNumbers: numbered(frame.rooms, this.rooms, this.rooms ? this.roomNumbers : []) });
    if (frame.inCycle !== this.inCycle) this.set("run", { inCycle: frame.inCycle });
    if (frame.doors) this.set("doors", { doors: frame.doors });
    if (frame.cycle) this.set("cycle", { cycle: frame.cycle });
    const now = performance.now();
    const turned = before?.finished !== frame.status.finished || before.mode !== frame.status.mode;
    if (turned || !this.playing || now - this.#notifiedAt >= 100) {
      this.#notifiedAt = now;
      this.notify("frame");
    }
  }

  /** The thing on the map that is described, if any. */
  get thing(): Thing | null {
    return this.chosen?.things[this.chosen.at] ?? null;
  }

  /** Describes what was pointed at; with no things, nothing. */
  choose(things: readonly Thing[], at = 0): void {
    if (things.length === 0 && !this.chosen) return;
    this.set("chosen", { chosen: things.length > 0 ? { things, at } : null, examined: null, outline: [] });
  }

  /** Shows and hides layers; others stay as they are. */
  setLayers(patch: Partial<Record<LayerName, boolean>>): void {
    this.set("view", { layers: { ...this.layers, ...patch } });
  }

  /** Puts a layer directly over or under another one. */
  moveLayer(name: LayerName, side: "over" | "under", other: LayerName): void {
    const rest = this.layerOrder.filter((layer) => layer !== name);
    rest.splice(rest.indexOf(other) + (side === "over" ? 1 : 0), 0, name);
    this.set("view", { layerOrder: rest });
  }

  toggleLayer(name: LayerName): void {
    this.setLayers({ [name]: !this.layers[name] });
  }

  point(spot: Partial<Spot>): void {
    this.set("spot", { spot: { ...this.spot, ...spot } });
  }

  note(entry: LogEntry): void {
    this.log = withEntry(this.log, entry);
    this.marks = marked(this.marks, entry);
    this.notify("log");
  }

  /** A new action: the recorded future of the run is void, and the last run is no longer
      offered. */
  #fork(): void {
    if (this.lastRun) this.set("last", { lastRun: null });
    const time = this.status?.time ?? 0;
    if (this.furthest <= time) return;
    this.furthest = time;
    this.set("run", { marks: this.marks.filter((mark) => mark.time <= time) });
  }
}

/** The matrix of the state before is kept with its own landmarks if the new one has none. */
function withMatrix(next: Inspection, before: Inspection | null): Inspection {
  if (next.coefficients.length > 0 || !before) return next;
  const { robotRows, landmarks, coefficients } = before;
  return { ...next, robotRows, landmarks, coefficients };
}
