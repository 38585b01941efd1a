// The page's end of the connection to the worker: sends commands, passes frames to scene and store.

import { degrees } from "./angle.js";
import { hostOf, tokenOf } from "./bridge_address.js";
import { type Compared, shownRun } from "./compared.js";
import { isExample, presentExample } from "./example.js";
import { Files } from "./files.js";
import { keepSimulation, lastRun } from "./last_run.js";
import { notePassed, withoutFault } from "./lessons.js";
import { isLink, isSharedWorld } from "./link.js";
import { LoadedMaps } from "./loaded_maps.js";
import { PageAddress } from "./page_address.js";
import { type Answer, type Command, handle, type Handlers, type Question } from "./protocol.js";
import { needsPriorMap } from "./protocol/methods.js";
import type { EditName, Level, MapStart, MethodName, PriorMapSetup, SavedFile, SavedKind, SettingValues, Setup, SourceKind } from "./protocol/module.js";
import { SAMPLE } from "./protocol/sample.js";
import type { Tuning } from "./protocol/setup.js";
import { Robot } from "./robot.js";
import { downloadAll } from "./save.js";
import type { Contest, Store, Toast } from "./store.js";
import { greet } from "./tour.js";
import type { Scene } from "./view/scene.js";
import { LEAST_MOVE } from "./view/submaps.js";
import { choices, forgetChoices, noteChoice } from "./visit.js";
import { WayBack } from "./way_back.js";
import { t } from "./words.js";

/** A worker that fails within this time after the last failure, in wall milliseconds, would go on
    failing. */
const SOON_AGAIN_MILLIS = 10_000;

/** Files of one kind; if there are none, the reason. */
export interface Collected {
  readonly files: readonly SavedFile[];
  readonly error: string;
}

/** Commands that begin another run. */
const BEGINS: ReadonlySet<Command["kind"]> = new Set(["start", "follow", "replay", "connect", "cable", "begin-at"]);

export class Client {
  #worker = this.#startWorker();
  #brokeAt = -Infinity;
  #run = 0;
  #undrawn = false;
  #simSpeed = 1;
  /** A note about the run that is about to start: which parts of its building were left out, or
      which run it replaces. */
  #skipped = "";
  readonly files: Files;
  readonly robot: Robot;
  readonly address: PageAddress;
  readonly loadedMaps: LoadedMaps;
  readonly #way: WayBack;
  /** Called when a run begins, before its first frame. */
  onStart: (isAgain: boolean) => void = () => {};
  /** Called if there is no run and will be none: none could begin, or the worker is gone. */
  onLost: () => void = () => {};
  /** Called when a new worker replaces one that failed: it has no state yet. */
  onRestart: () => void = () => {};
  /** Called with each command; if it returns true, the command is handled elsewhere. */
  diverts: (command: Command) => boolean = () => false;
  #askLink: ((link: string | null) => void)[] = [];
  /** Who waits for files, in the order of asking. */
  #collecting: ((collected: Collected) => void)[] = [];

  /** `isBeside`: this client's run is only compared with the one that is shown, and controls
      nothing in the page. */
  constructor(private readonly store: Store, private readonly scene: Scene, private readonly isBeside = false) {
    this.files = new Files(this, store);
    this.robot = new Robot(this, store);
    this.address = new PageAddress(this, store);
    this.loadedMaps = new LoadedMaps(this, store);
    this.#way = new WayBack(store, this);
  }

  #startWorker(): Worker {
    const worker = new Worker(new URL("worker.js", import.meta.url), { type: "module", name: "slamlab" });
    worker.onmessage = (event: MessageEvent<Answer>) => handle(this.#handlers, event.data);
    worker.onerror = (event) => this.#broke(event.message || "the worker could not be started");
    return worker;
  }

  /** The worker failed: starts another one, unless the last failure was just before. */
  #broke(why: string): void {
    const breaksAgain = performance.now() - this.#brokeAt < SOON_AGAIN_MILLIS;
    this.#brokeAt = performance.now();
    this.#worker.terminate();
    for (const give of this.#collecting.splice(0)) give({ files: [], error: why });
    for (const give of this.#askLink.splice(0)) give(null);
    if (this.isBeside || breaksAgain) {
      this.warn(t`The simulation stopped: ${why}. Reload the page.`);
      this.onLost();
      return;
    }
    this.#worker = this.#startWorker();
    this.#run = 0;
    this.#undrawn = false;
    this.#answered(false);
    this.store.set("run", { loading: "", reading: null, seeking: null });
    this.onRestart();
    if (this.store.source === "bridge") this.again();
    else {
      this.start(this.store.started);
      this.store.set("last", { lastRun: lastRun() });
    }
    this.warn(t`The simulation broke off by a fault of the program: ${why}. It was started anew.`);
  }

  send(command: Command, transfer: Transferable[] = []): void {
    if (!this.diverts(command)) this.relay(command, transfer);
  }

  /** Sends a command past `diverts`. */
  relay(command: Command, transfer: Transferable[] = []): void {
    // Whoever begins something here does not want the offer of the last run.
    if (this.store.lastRun && BEGINS.has(command.kind)) this.store.set("last", { lastRun: null });
    this.#worker.postMessage(command, transfer);
  }

  /** The link of the simulation as if it had begun with `setup`; null if no link can describe what
      was done in it. */
  linkOf(setup: Setup): Promise<string | null> {
    this.relay({ kind: "keep", setup, asked: true });
    return new Promise((resolve) => this.#askLink.push(resolve));
  }

  /** The files of this kind as they would be saved now, or why there are none. */
  collect(what: SavedKind): Promise<Collected> {
    this.relay({ kind: "collect", what });
    return new Promise((resolve) => this.#collecting.push(resolve));
  }

  tellSaved(names: readonly string[]): void {
    const text = t`Saved ${names.join(", ")}`;
    this.note("good", text);
    this.store.set("toast", { toast: { level: "good", text } });
  }

  /** Ends the worker for good. */
  end(): void {
    this.#worker.terminate();
  }

  /** Run time up to which the next run goes at once, s. */
  #until: number | null = null;
  /** What was asked of simulated runs that have not begun yet, and the number of such runs. */
  #asked: Partial<Setup> = {};
  #starts = 0;

  /** A requested run began or failed. After a run of another kind, no request is pending. */
  #answered(isSimulated: boolean): void {
    this.#starts = isSimulated ? Math.max(this.#starts - 1, 0) : 0;
    if (this.#starts === 0) this.#asked = {};
  }

  /** Starts a simulated run with the present setup, changed by `patch`. */
  start(patch: Partial<Setup> = {}): void {
    // Changing the building, robot or noise leaves the lesson.
    const leaves = patch.lesson === undefined && (["world", "worldJson", "sensor", "seed"] as const).some((part) => part in patch);
    const asked = leaves ? { settings: withoutFault(this.store), ...patch, lesson: null } : patch;
    // If somebody chooses a world and a sensor in quick succession, both apply.
    const setup = { ...this.store.setup, ...this.#asked, ...asked };
    // There is no way back to a lesson or the tour: both can be started again. While another run is
    // on its way, the worker no longer knows the run that is shown.
    const isMissed = setup.lesson === null && this.store.tour === null && !this.isBeside;
    if (isMissed && this.#starts === 0) this.#way.leave();
    this.#asked = { ...this.#asked, ...asked };
    this.#starts += 1;
    this.store.set("run", { loading: setup.world });
    this.send({ kind: "start", setup, play: true });
  }

  setSpeed(factor: number): void {
    this.store.set("run", { speed: factor });
    this.send({ kind: "speed", factor });
  }

  /** Turns the cycle on or off, in this run and in those that follow. */
  setCycle(on: boolean): void {
    const { store } = this;
    // Both would cover the map.
    store.set("run", { setup: { ...store.setup, cycle: on }, editing: on ? null : store.editing });
    // The stages refer to the lines of a scan, so those are shown.
    store.setLayers({ found: on });
    this.send({ kind: "cycle", on });
    if (on && store.source === "sim" && store.status?.mode === "manual") this.explore();
    else this.#wake();
  }

  /** Applies settings to this run and later ones; what acts only on a restart waits for one. */
  configure(settings: SettingValues): void {
    const { store } = this;
    store.set("settings", { setup: { ...store.setup, settings } });
    this.send({ kind: "configure", settings });
    this.#list();
    if (!this.isBeside) noteChoice(store, { settings });
  }

  /** Asks for the settings of this run. */
  #list(): void {
    this.send({ kind: "settings", settings: this.store.setup.settings });
  }

  /** Uses the settings fitted to a drive in place of earlier ones; null: the robot's own
      calibration again. A recording is mapped again. */
  usePreset(preset: Tuning["preset"]): void {
    const { store } = this;
    const before = Object.keys(store.tuning.preset?.settings ?? {});
    const others = Object.entries(store.setup.settings).filter(([key]) => !before.includes(key));
    store.set("fit", { tuning: { ...store.tuning, preset } });
    this.configure({ ...Object.fromEntries(others), ...preset?.settings });
    this.#fromTheBeginning();
  }

  /** A simulated twin beside the robot, or none. A recording is mapped again, because its twin
      starts where it does. */
  setTwin(twin: boolean): void {
    const { store } = this;
    store.set("fit", { tuning: { ...store.tuning, twin } });
    this.send({ kind: "twin", on: twin });
    this.#fromTheBeginning();
  }

  /** A recording is mapped again from its beginning. */
  #fromTheBeginning(): void {
    if (this.store.source === "replay") this.again();
    this.store.notify("run");
  }

  /** Connects to the page's own server if it is a bridge with a robot; otherwise starts the
      simulation. */
  async begin(): Promise<void> {
    const token = tokenOf(location);
    const { host, url } = await hostOf(location);
    this.store.set("bridge", { host });
    if (url) this.robot.connect(url, token);
    else if (!this.address.open(location.hash) && (isSharedWorld(location.hash) || !greet(this.store, this))) {
      const { speed = this.store.speed, ...setup } = choices();
      this.setSpeed(speed);
      this.start(setup);
      this.store.set("last", { lastRun: lastRun() });
    }
  }

  /** Starts the run again in the saved map, from this start in it. */
  beginAt(start: MapStart): void {
    const { store } = this;
    if (!store.savedMap) return;
    store.set("run", { savedMap: { ...store.savedMap, start } });
    this.send({ kind: "begin-at", start });
    this.again("scan-matching");
  }

  /** Shows or hides submaps. If some are shown, their layer is turned on. */
  hideSubmaps(hidden: ReadonlySet<number>): void {
    const { store, scene } = this;
    store.set("submaps", { hiddenSubmaps: hidden });
    store.setLayers({ submaps: hidden.size < scene.submaps.count });
  }

  #examinedNumber = 0;

  /** Asks the run what it knows of something in the map. Older questions no longer need an
      answer. */
  examine(question: Question): void {
    this.send({ kind: "examine", number: (this.#examinedNumber += 1), ...question });
  }

  /** Changes the map between two places (map frame, m): opposite corners of a region, or the ends
      of a wall. */
  edit(what: EditName, [x0, y0]: readonly [number, number], [x1, y1]: readonly [number, number]): void {
    const corners = what === "erase" ? [x0, y0, x1, y0, x1, y1, x0, y1] : [x0, y0, x1, y1];
    this.send({ kind: "edit", what, corners });
  }

  /** Carries the simulated robot elsewhere. */
  kidnap(): void {
    this.send({ kind: "kidnap" });
    this.#wake();
  }

  /** Opens or shuts a door of the world. It moves with the next step, so a paused run goes on. */
  setDoor(index: number, open: boolean): void {
    this.send({ kind: "door", index, open });
    this.#wake();
  }

  explore(): void {
    this.#order({ kind: "explore" });
  }

  /** Goes to a moment of the run, s. The run waits there, and repeats itself from there until
      something else is done. */
  seek(time: number): void {
    this.#way.keep();
    this.store.set("run", { seeking: time });
    this.send({ kind: "seek", time });
  }

  /** Goes back to the scan before. */
  back(): void {
    if (this.store.source === "bridge") return;
    this.#way.keep();
    this.send({ kind: "back" });
  }

  manual(): void {
    this.#slowDown();
    this.#order({ kind: "manual" });
  }

  /** Slows down to real time: nobody can steer faster than that. */
  #slowDown(): void {
    if (this.store.source === "sim" && this.store.speed > 1) this.setSpeed(1);
  }

  /** The next click on the map chooses the goal. */
  aim(): void {
    this.store.set("run", { aiming: true });
  }

  goTo(x: number, y: number): void {
    this.#order({ kind: "goto", x, y });
  }

  #order(command: Command): void {
    this.store.set("run", { aiming: false, isStopped: false });
    this.send(command);
    this.#wake();
  }

  /** Runs all planners as soon as there is a goal; without a start they begin at the robot. */
  contest(patch: Partial<Pick<Contest, "ground" | "seconds" | "start" | "goal">>): void {
    const { store } = this;
    const contest = { ...store.contest, ...patch, picking: "goal" as const, error: "" };
    store.set("contest", { contest });
    const { ground, seconds, start, goal, watched } = contest;
    const from = start ?? (store.status ? [store.status.x, store.status.y] as const : null);
    if (goal && from) this.send({ kind: "contest", ask: { ground, ends: [...from, ...goal], seconds }, watched });
  }

  /** Chooses the planner whose tree is drawn. */
  watch(watched: number): void {
    const { store } = this;
    store.set("contest", { contest: { ...store.contest, watched } });
    this.send({ kind: "contest-watch", watched });
  }

  drive(forward: number, turn: number): void {
    this.send({ kind: "drive", forward, turn });
    if (forward === 0 && turn === 0) return;
    if (this.store.status?.mode !== "manual") this.#slowDown();
    if (this.store.isStopped) this.store.set("run", { isStopped: false });
    this.#wake();
  }

  stop(): void {
    this.store.set("run", { aiming: false, isStopped: true });
    this.robot.stop();
    const { source, reading } = this.store;
    // A robot can be stopped even while a recording is being read.
    if (source === "bridge" || (source === "sim" && !reading)) this.send({ kind: "stop" });
    if (reading || source === "replay") this.send({ kind: "cancel" });
  }

  /** Repeats the experiment of a link: up to a moment, s, at once, or at its own speed. */
  follow(link: string, until: number | null = null): void {
    this.store.set("run", { loading: "the experiment" });
    this.#until = until;
    this.send({ kind: "follow", link });
  }

  /** Puts the link of this run into the address and on the clipboard. */
  copyLink(): void {
    this.send({ kind: "link", setup: this.store.started });
  }

  /** Starts the present run again, with the given method or the one that it had. */
  again(method?: MethodName): void {
    const { store } = this;
    if (store.source === "bridge" && this.robot.again(method ?? store.method)) return;
    if (store.source === "replay" && this.files.recording) void this.files.open(this.files.recording, method ?? store.method);
    else this.start({ mode: "explore", ...(method === undefined ? {} : { method }) });
  }

  /** Whether there is a run. */
  get hasRun(): boolean {
    return this.#run !== 0;
  }

  /** Reports a request that cannot be met; the run that begins instead keeps the message. */
  refuse(text: string): void {
    if (this.#run === 0) this.#skipped = text;
    else this.warn(text);
  }

  /** A message to be read at once. */
  warn(text: string, way?: Toast["way"]): void {
    this.store.set("toast", { toast: { level: "warn", text, ...(way && { way }) } });
  }

  /** Uses the map drawn so far as a prior map. */
  localiseInThisMap(): void {
    this.send({ kind: "read-prior-map", name: t`map of ${this.store.title}`, files: [] });
  }

  /** Localises the robot in this map from here on; null: among the walls of the world. */
  localiseIn(priorMap: PriorMapSetup | null, method?: MethodName): void {
    const { store } = this;
    store.set("run", { setup: { ...store.setup, priorMap } });
    this.again(method ?? (needsPriorMap(store.method) ? store.method : "prior-map"));
  }

  /** The last frame is on the screen: the worker may send another. */
  drawn(): void {
    if (!this.#undrawn) return;
    this.#undrawn = false;
    this.send({ kind: "drawn" });
  }

  /** A recording goes as fast as it can; a simulation after it goes as fast as the one before. */
  #pace(next: SourceKind): void {
    if (next === "replay" && this.store.source === "sim") this.#simSpeed = this.store.speed;
    if (next === "sim" && this.store.source === "replay") this.store.speed = this.#simSpeed;
    this.setSpeed(next === "replay" ? Infinity : this.store.speed);
  }

  /** A command to the robot means that it should move, so a paused run goes on. */
  #wake(): void {
    if (!this.store.playing) this.send({ kind: "play" });
  }

  readonly #handlers: Handlers<Answer> = {
    ready: (offer) => {
      this.store.set("run", { offer });
      this.address.offered();
      if (!this.isBeside) this.robot.prepare();
    },
    started: (start) => {
      this.#answered(start.setup !== null);
      this.#run = start.run;
      this.robot.begins(start.source);
      this.store.compared = this.files.begins(start.source) ? this.#comparedWith(start.method) : [];
      // Going back to an earlier moment keeps the view and the speed.
      if (!start.isAgain) this.#pace(start.source);
      this.scene.clear();
      this.store.begin(start);
      this.#list();
      this.onStart(start.isAgain);
      if (start.source === "sim" && !start.isAgain && !this.isBeside) void this.#way.offerBefore();
      if (this.#until !== null) this.seek(this.#until);
      this.#until = null;
      if (!start.isAgain && isExample(this.files.recording) && start.source === "replay") presentExample(this.store, this);
      if (this.#skipped === "") return;
      this.store.note({ time: 0, level: "warn", text: this.#skipped });
      this.warn(this.#skipped);
      this.#skipped = "";
    },
    frame: (frame) => {
      if (frame.run !== this.#run) return;
      this.#undrawn = true;
      const moved = this.scene.take(frame, Date.now());
      const { furthest } = this.store;
      this.store.take(frame);
      if (this.store.furthest < furthest) void this.#way.offer();
      if (frame.submaps) this.store.notify("submaps");
      if (moved >= LEAST_MOVE) this.store.set("moved", { moved });
    },
    topics: ({ name, offered }) => this.store.set("run", { asked: { name, offered } }),
    reading: ({ name, done }) => this.store.set("run", { reading: done === null ? null : { name, done } }),
    playing: ({ playing }) => {
      this.store.set("run", { playing, seeking: playing ? this.store.seeking : null });
      this.store.notify("frame");
    },
    hash: ({ run, text }) => {
      if (run === this.#run) this.store.hash = text;
    },
    event: (event) => {
      if (event.run !== this.#run) return;
      this.store.note(event);
      if (event.alert) this.store.set("toast", { toast: event });
    },
    bench: ({ response }) => this.store.set("bench", { bench: response }),
    settings: ({ settings }) => this.store.set("settings", { settings }),
    "followed-settings": ({ run, settings }) => {
      if (run !== this.#run) return;
      this.store.set("settings", { setup: { ...this.store.setup, settings } });
      this.#list();
    },
    calibrated: ({ calibration, error }) => this.store.set("calibration", { calibration: { fit: calibration, error } }),
    sigma: (sigma) => this.store.set("sigma", { sigma }),
    fit: (fit) => this.store.set("fit", { fit }),
    "truth-errors": ({ run, errors: { times, position, heading } }) => {
      if (run !== this.#run) return;
      this.store.history.correct(times, [[SAMPLE.positionError, position], [SAMPLE.headingError, heading.map((turn) => Math.abs(degrees(turn)))]]);
      this.store.notify("frame");
    },
    quality: ({ run, quality }) => {
      if (run !== this.#run) return;
      this.store.set("quality", { quality, judging: null });
      // The tears may have moved or changed their meaning.
      if (this.store.thing?.kind === "torn") this.store.choose([]);
    },
    grade: ({ run, grade }) => {
      if (run !== this.#run) return;
      const { started: { lesson }, grade: before } = this.store;
      // A passed lesson stays passed and is reported again and again.
      if (lesson && grade?.isPassed && !before?.isPassed) notePassed(lesson);
      this.store.set("lesson", { grade });
    },
    judging: ({ run, part }) => {
      if (run === this.#run) this.store.set("quality", { judging: part });
    },
    preset: ({ name, settings }) => {
      this.usePreset({ name, settings });
      this.note("good", t`The preset "${name}" is in use`);
    },
    contest: ({ contest: found, running, error }) => this.store.set("contest", { contest: { ...this.store.contest, found, running, error } }),
    examined: (examined) => {
      if (examined.run === this.#run && examined.number === this.#examinedNumber) this.store.set("chosen", { examined });
    },
    bridge: ({ state, walls }) => this.store.set("bridge", { bridge: state, bridgeWalls: walls ?? this.store.bridgeWalls }),
    "world-file": ({ world, text }) => this.files.desk?.openAsked(world, text),
    "world-checked": ({ number, fault }) => this.files.desk?.judge(number, fault),
    built: ({ name, worldJson, skipped }) => {
      if (this.files.desk) return this.files.desk.open(name, worldJson, skipped);
      this.start({ world: name, worldJson, mode: "explore" });
      this.#leaveOut(name, skipped);
    },
    "prior-map": ({ priorMap, skipped }) => {
      this.localiseIn(priorMap);
      this.#leaveOut(priorMap.name, skipped);
    },
    "going-on": ({ name, picture, begins, told }) => {
      this.store.set("run", { loading: "", savedMap: picture && { name, picture, start: { from: "left" }, isBegun: false } });
      if (begins) this.again("scan-matching");
      this.note("good", told);
    },
    "map-loaded": (loaded) => this.loadedMaps.loaded(loaded),
    "map-aligned": (aligned) => this.loadedMaps.aligned(aligned),
    renumbered: ({ submap, by }) => {
      const { store } = this;
      // Submaps behind it are renumbered.
      const renumbered = [...store.hiddenSubmaps].filter((hidden) => by === 1 || hidden !== submap).map((hidden) => (hidden > submap || (by === 1 && hidden === submap) ? hidden + by : hidden));
      store.choose([]);
      store.set("submaps", { hiddenSubmaps: new Set(renumbered), chosenSubmap: by === 1 ? submap : null });
    },
    "solved-graph": (solvedGraph) => {
      this.store.set("graph", { solvedGraph });
      this.store.set("tab", { tab: "run" });
      this.note("good", t`The pose graph ${solvedGraph.name} is solved: it is drawn under Run`);
    },
    saved: ({ files }) => {
      downloadAll(files);
      this.tellSaved(files.map((file) => file.name));
    },
    collected: (collected) => this.#collecting.shift()?.(collected),
    link: ({ link }) => void this.address.give(link),
    kept: ({ link, asked }) => {
      if (asked) this.#askLink.shift()?.(link);
      else keepSimulation(this.store, link);
    },
    failed: ({ text, isBroken }) => {
      if (isBroken) {
        this.#broke(text);
        return;
      }
      this.#answered(true);
      this.store.set("run", { loading: "", seeking: null });
      this.note("warn", text);
      this.warn(text, this.files.wayOutOf(text));
      // After a bad link there is no run to look at.
      if (this.#run === 0) this.onLost();
      if (this.isBeside || this.#run !== 0) return;
      // Choices kept by another build may not work either.
      if (isLink(location.hash)) history.replaceState(null, "", location.pathname + location.search);
      else if (!forgetChoices()) return;
      this.#skipped = text;
      this.start();
    },
  };

  /** What methods other than `next` made of the log, including the run that ends here. */
  #comparedWith(next: MethodName): readonly Compared[] {
    const left = shownRun(this.store, this.scene);
    const earlier = this.store.compared.filter(({ method }) => method !== left?.method);
    return (left ? [...earlier, left] : earlier).filter(({ method }) => method !== next);
  }

  /** Adds a line to the log, at this moment of the run. */
  note(level: Level, text: string): void {
    this.store.note({ time: this.store.status?.time ?? 0, level, text });
  }

  /** Keeps a note of what was left out of a file, to be shown when its run begins. */
  #leaveOut(name: string, skipped: readonly string[]): void {
    this.#skipped = skipped.length > 0 ? t`${name}: left out ${skipped.join(", ")}.` : "";
  }
}
