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
/** Empty where none was chosen, or it was shut again. */
export type Tab = (typeof TABS)[number] | "";

/** `frame` is notified at most ten times a second, the others at once. */
export type Topic = "frame" | "run" | "view" | "log" | "toast" | "tab" | "theme" | "inspection" | "spot" | "bench" | "cycle" | "settings" | "calibration" | "sigma" | "bridge" | "doors" | "contest" | "fit" | "rooms" | "chosen" | "moved" | "quality" | "graph" | "submaps" | "tour" | "exhibit" | "lesson" | "last" | "offline" | "gamepad" | "drawing";

/** Walls that light up on the map, in the matrix and in the list of matches. */
export interface Spot {
  /** Under the pointer, wherever that is. */
  readonly hovered: readonly number[];
  /** Chosen by a click, until another is. */
  readonly pinned: number | null;
}

/** A contest of planners as it is asked, and how it stands. */
export interface Contest {
  readonly ground: Ground;
  readonly seconds: number;
  /** Map frame, m; null where the robot is, or not yet chosen. */
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
  /** What can be done about it. */
  way?: { readonly label: string; readonly go: () => void };
  /** How long it stands, wall milliseconds, unless it is closed; else as its level has it. */
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
  /** Where it lies in the map of this run; null while that is not known, and why. */
  readonly alignment: MapAlignment | PathPlace | null;
  /** Of poses over time, which have a way alone. */
  readonly path: Omit<PosePathPicture, "way"> | null;
  readonly error: string;
  /** Whether it is being looked for. */
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
  /** A log that is being read, and how much of it is (0 to 1). */
  reading: { name: string; done: number } | null = null;
  /** A recording of ROS with several topics of a kind, until it is said which are meant. */
  asked: { name: string; offered: RosTopics } | null = null;
  /** Poses that were given, until it is said what they are; without a log they are beside the one
      that is shown. */
  posesAsked: { poses: File; log: File | null } | null = null;
  /** The saved map that runs by scan matching go on in. */
  savedMap: SavedMap | null = null;
  /** The pose graph that was opened last. */
  solvedGraph: { readonly name: string; readonly graph: SolvedGraph } | null = null;
  /** What a press on the map changes; null while it moves the view. */
  editing: EditName | null = null;
  /** The geofence that is being drawn. */
  fence: FenceDraft | null = null;
  /** World that is being loaded; empty when none is. */
  loading = "";
  speed = 4;
  /** What can be chosen; empty until the module is there. */
  offer: Offer = { worlds: [], sensors: [], methods: [], devices: [], presets: [], lessons: [], dataSheet: "" };
  setup: Setup = { world: "office", worldJson: null, sensor: "lidar", seed: 7, method: "line-ekf", mode: "explore", cycle: false, settings: {}, calibration: null, priorMap: null, lesson: null };
  /** What the present run was started from: settings that wait for a restart differ. */
  started: Setup = this.setup;
  /** All settings, with what each is in this run. */
  settings: SettingInfo[] = [];
  calibration: { fit: Calibration | null; error: string } = { fit: null, error: "" };
  sigma: { curve: SigmaCurve | null; error: string } = { curve: null, error: "" };
  /** The fit of the drive, and what of it is in use. */
  fit: { fit: DriveFit | null; error: string } = { fit: null, error: "" };
  tuning: Tuning = { preset: null, twin: false };
  /** Samples of the twin. */
  readonly twin = new History(TWIN_STRIDE);
  /** Doors of the simulated world, see DOOR. */
  doors: Float32Array = new Float32Array(0);
  /** What serves this page; null while that is not known. */
  host: Host | null = null;
  /** The bridge that is being talked to. */
  bridge: BridgeState | null = null;
  /** The walls of the bridge's own map, in its frame. */
  bridgeWalls: Float32Array = new Float32Array(0);
  /** Whether the robot drives by the cycle, and what its stages gave. */
  inCycle = false;
  cycle: Cycle | null = null;
  /** Of the present run. */
  method: MethodName = this.setup.method;
  /** Go to is chosen, and the next click on the map says where. */
  aiming = false;
  /** Stop was pressed, and nothing else was asked of the robot since. */
  isStopped = false;
  /** As far as the run came, or the one that it goes the way of again, s. */
  furthest = 0;
  /** What happened up to there. */
  marks: readonly Mark[] = [];
  /** The moment that it is on the way to, s. */
  seeking: number | null = null;
  follow = false;
  gridView: GridView = "continuous";
  layers: Record<LayerName, boolean> = Object.fromEntries(
    LAYERS.map((name) => [name, !["tree", "rawPath", "found", "points", "landmarks", "rooms", "submaps", "graph", "wheels"].includes(name)]),
  ) as Record<LayerName, boolean>;
  /** Layers from the ground up. */
  layerOrder: readonly LayerName[] = LAYERS;
  /** What the map is drawn with, and why not with WebGL2. */
  drawing: { readonly with: "canvas" | "webgl2"; readonly why: string } = { with: "canvas", why: "" };
  /** Whether the page opens without its server, and whether there is a newer build of it. */
  offline: Offline = { kind: "storing" };
  renewal: Renewal = null;
  theme: Theme = "system";
  tab: Tab = "";
  /** The filter's state, while its tab is open. */
  inspection: Inspection | null = null;
  spot: Spot = { hovered: [], pinned: null };
  /** What the drive controller did on the bench. */
  bench: BenchResponse | null = null;
  contest: Contest = { ground: "truth", seconds: 1, start: null, goal: null, picking: "goal", watched: 3, found: null, running: false, error: "" };
  /** Rooms and doors, while their layer is on, and a place in the one that was chosen, m. */
  rooms: Rooms | null = null;
  /** The number of each of them, from 1; it stays while the map grows. */
  roomNumbers: readonly number[] = [];
  roomSpot: readonly [number, number] | null = null;
  /** Whether a click on the map asks what is there, and does nothing else. */
  inspecting = false;
  /** What lies where somebody pointed at the map, and which of it is told. */
  chosen: { readonly things: readonly Thing[]; readonly at: number } | null = null;
  /** What the run says of it, once it has answered. */
  examined: Examined | null = null;
  /** Its outline on the map, m. */
  outline: Outline = [];
  /** Submaps that are not drawn, the one that was chosen in their list, and those that can be put
      back, the last one last. */
  hiddenSubmaps: ReadonlySet<number> = new Set();
  chosenSubmap: number | null = null;
  /** Maps that were loaded, the first one first. */
  loadedMaps: readonly LoadedMap[] = [];
  /** What other methods made of the recording that is shown. */
  compared: readonly Compared[] = [];
  /** By how much the last loop closure moved the map, m. */
  moved = 0;
  /** What the map was worth when it was asked for. */
  quality: Quality | null = null;
  /** What was left on the last visit, while it is offered. */
  lastRun: LastRun | null = null;
  /** What this try at a lesson has reached. */
  grade: Grade | null = null;
  /** The part that is done where the map is being judged, 0 to 1. */
  judging: number | null = null;
  /** The step of a first visit; null outside of one. */
  tour: TourStep | null = null;
  /** The experiment of the gallery that is shown. */
  exhibit: Shown | null = null;
  /** The gamepad that is connected, and what it says. */
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

  /** The planners are compared: a click on the map chooses their start or goal. */
  get comparesPaths(): boolean {
    return this.tab === "paths";
  }

  /** Whether what is shown is a robot that is not heard. */
  get isCutOff(): boolean {
    return this.source === "bridge" && this.bridge?.connection !== "open";
  }

  /** A run begins: what was shown of the one before is gone. */
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
    // A recording that is mapped again with what was fitted to it keeps the table.
    if (source !== this.source || title !== this.title) this.fit = { fit: null, error: "" };
    // Another map: its places are others. Only a simulation knows true walls.
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

  /** What of the map is told, if anything is. */
  get thing(): Thing | null {
    return this.chosen?.things[this.chosen.at] ?? null;
  }

  /** Tells of what was pointed at; nothing more where there is nothing. */
  choose(things: readonly Thing[], at = 0): void {
    if (things.length === 0 && !this.chosen) return;
    this.set("chosen", { chosen: things.length > 0 ? { things, at } : null, examined: null, outline: [] });
  }

  /** Shows and hides layers; others stay as they are. */
  setLayers(patch: Partial<Record<LayerName, boolean>>): void {
    this.set("view", { layers: { ...this.layers, ...patch } });
  }

  /** Puts a layer just over another one, or just under it. */
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

  /** Something was done that was not done before: what came after is no longer to come, and who
      does something here wants nothing else. */
  #fork(): void {
    if (this.lastRun) this.set("last", { lastRun: null });
    const time = this.status?.time ?? 0;
    if (this.furthest <= time) return;
    this.furthest = time;
    this.set("run", { marks: this.marks.filter((mark) => mark.time <= time) });
  }
}

/** The matrix that was there before goes with its own landmarks: without a new one there is
    none. */
function withMatrix(next: Inspection, before: Inspection | null): Inspection {
  if (next.coefficients.length > 0 || !before) return next;
  const { robotRows, landmarks, coefficients } = before;
  return { ...next, robotRows, landmarks, coefficients };
}
