// Runs the core for the page: apart from local_bridge.ts and registration/worker.ts the only file
// that starts a WebAssembly module. Each command of the page has one handler.

import init, { WebRun, offer, read_link } from "../pkg/slamlab_web.js";
import { fail, post } from "./answer.js";
import { faultOf } from "./fault.js";
import { type Command, handle, type Handlers } from "./protocol.js";
import type { Renumbering } from "./protocol/frame.js";
import type { EditName, Setup } from "./protocol/module.js";
import { CableLink } from "./source/cable.js";
import { Conversation, type ConversationSetup, type Wire } from "./source/conversation.js";
import { BridgeLink } from "./source/bridge_link.js";
import type { Watched } from "./source/extras.js";
import { fileModule } from "./source/file_module.js";
import { micros } from "./source/link.js";
import { GoingOn } from "./source/going_on.js";
import { LoadedMaps } from "./source/loaded_maps.js";
import { Player, SLICE_MILLIS } from "./source/player.js";
import { given, questions } from "./source/questions.js";
import { Rest } from "./rest.js";
import { LogReading } from "./source/reading.js";
import { RosImport } from "./source/ros.js";
import { Run } from "./source/run.js";
import { titleOf } from "./worlds.js";

/** Steps within which a simulated sensor is certain to scan. */
const MOST_STEPS = 400;

const player = new Player();
let reading: LogReading | null = null;
let importing: RosImport | null = null;
/** Identifies the import that waits for the module of file formats. */
let asksFor: symbol | null = null;
let conversation: Conversation | null = null;
const savedMap = new GoingOn();
const loadedMaps = new LoadedMaps();

function stopReading(): void {
  reading?.free();
  importing?.free();
  reading = importing = player.before = null;
  post({ kind: "reading", name: "", done: null });
  player.resume();
}

/** Stops reading a file. Returns whether one was being read. */
function interrupt(): boolean {
  asksFor = null;
  const isReading = reading !== null || importing !== null;
  if (isReading) stopReading();
  return isReading;
}

type Replay = Extract<Command, { kind: "replay" }>;

/** Reads a log slice by slice, and begins its run. `notes`: messages of its import. */
function readLog(replay: Replay, notes: readonly string[]): void {
  const { kind: _, name, bytes, topics, ...setup } = replay;
  const log = new LogReading(name, bytes, setup);
  reading = log;
  player.before = () => {
    try {
      const run = log.readOn(SLICE_MILLIS);
      if (!run) return true;
      reading = null;
      begin(new Run(savedMap.take(run), { kind: "replay", title: name, method: run.method() }, `Opened ${name}: ${run.summary()}`, notes), { setup: null, playing: true });
    } catch (error) {
      stopReading();
      if (faultOf(error).about === "ros") void importRos(replay);
      else fail(error, name);
    }
    return false;
  };
  player.schedule();
}

/** Converts a ROS recording to our format, slice by slice, and reads the result. */
async function importRos(replay: Replay): Promise<void> {
  const { name, bytes, topics } = replay;
  const asked = (asksFor = Symbol(name));
  const module = await fileModule().catch((error: unknown) => fail(error, name));
  // Something else was begun meanwhile.
  if (!module || asked !== asksFor) return;
  const ros = importing = new RosImport(module, name, bytes, topics);
  player.before = () => {
    try {
      const imported = ros.readOn(SLICE_MILLIS);
      if (!imported) return true;
      stopReading();
      if (imported === "asked") return false;
      readLog({ ...replay, bytes: imported.bytes.buffer }, imported.notes);
      return true;
    } catch (error) {
      stopReading();
      fail(error, name);
    }
    return false;
  };
  player.schedule();
}

function disconnect(): void {
  conversation?.close();
  conversation = null;
}

function begin(run: Run, how: Parameters<Player["begin"]>[1]): void {
  disconnect();
  player.begin(run, how);
}

function converse(setup: ConversationSetup, wire: Wire): void {
  interrupt();
  disconnect();
  conversation = new Conversation(player, setup, wire);
}

/** Applies a command to the run, unless it is a recording, which takes none. */
function command(act: (run: Run) => void): void {
  const { run } = player;
  if (!run || run.kind === "replay") return;
  act(run);
  if (run.kind === "bridge") conversation?.say(() => {});
  player.changed();
}

/** Goes to another moment of the run. A file that is being read would come first, so reading
    stops. */
function seek(...where: Parameters<Player["seek"]>): void {
  interrupt();
  given("", () => player.seek(...where));
}

/** Edits the map of a run of any source. */
function changeMap(act: (module: WebRun) => void, words: string): void {
  player.run?.changeMap(act, words);
  player.changed();
}

/** Removes a submap from the map or puts one back. */
function renumber(act: (run: Run) => Renumbering | null): void {
  const { run } = player;
  if (!run) return;
  given("", () => {
    const renumbering = act(run);
    if (renumbering) post({ kind: "renumbered", ...renumbering });
  });
  player.changed();
  // The judgement of the whole map applied to another map.
  if (run.kind === "replay" && run.finished) player.judge();
}

/** The words for an edit in the log. */
const EDITED: Readonly<Record<EditName, string>> = {
  erase: "A region of the map was erased by hand",
  wall: "A wall was drawn by hand",
  glass: "Glass was drawn by hand",
};

/** Applies a command to the run, if it is a simulation. */
function simulated(act: (run: Run) => void): void {
  if (player.run?.kind === "sim") command(act);
}

/** `null` if no link can describe what a person did, or the world in it is too large. */
function linkOf({ module }: Run, setup: Setup): string | null {
  try {
    return module.link(setup);
  } catch {
    return null;
  }
}

const handlers: Handlers<Command> = {
  ...questions(player, savedMap),
  start: ({ setup, play }) => {
    interrupt();
    given(setup.worldJson === null ? "" : setup.world, () => {
      const { world: title, method, sensor, seed } = setup;
      const run = savedMap.take(WebRun.simulate(setup));
      begin(new Run(run, { kind: "sim", title, method }, `A robot with ${sensor} wakes up in ${titleOf(setup)}, seed ${seed}`), { setup, playing: play });
    });
  },
  follow: ({ link }) => {
    interrupt();
    const { setup, actions, seconds } = read_link(link);
    const { world: title, method, sensor, seed } = setup;
    const done = seconds.toFixed(0);
    const words = actions === 1
      ? `A link: a robot with ${sensor} wakes up in ${titleOf(setup)}, seed ${seed}; ${actions} thing was done in ${done} s`
      : `A link: a robot with ${sensor} wakes up in ${titleOf(setup)}, seed ${seed}; ${actions} things were done in ${done} s`;
    begin(new Run(WebRun.follow_link(link), { kind: "sim", title, method }, words), { setup, playing: true });
  },
  link: ({ setup }) => {
    const { run } = player;
    if (run) post({ kind: "link", link: run.module.link(setup) });
  },
  keep: ({ setup, asked = false }) => {
    const { run } = player;
    const link = run?.kind === "sim" ? linkOf(run, setup) : null;
    // The asking side waits for an answer.
    if (run?.kind === "sim" || asked) post({ kind: "kept", link, asked });
  },
  replay: (command) => {
    interrupt();
    readLog(command, []);
  },
  play: () => {
    if (player.run && !player.run.finished) player.play(true);
  },
  pause: () => {
    player.play(false);
    player.show();
  },
  step: () => {
    player.play(false);
    const { run } = player;
    const scans = run?.scans ?? 0;
    for (let i = 0; run && i < MOST_STEPS && run.scans === scans && !run.finished; i += 1) run.step();
    player.show();
  },
  seek: ({ time }) => seek((player.run?.time ?? 0) > time, (run) => run.isAt(time)),
  back: () => {
    const before = (player.run?.scans ?? 0) - 1;
    seek(true, (run) => run.scans >= before);
  },
  speed: ({ factor }) => player.setSpeed(factor),
  "hold-at": ({ time }) => player.holdAt(time),
  stage: () => {
    player.play(false);
    simulated((run) => run.nextStage());
  },
  cycle: ({ on }) => command((run) => run.command((module) => module.set_cycle(on), on ? "Drives by the cycle: scan standing, plan, one turn, one leg, again" : "Drives while it scans")),
  door: ({ index, open }) => simulated((run) => {
    run.command((module) => module.set_door(index, open), `Door ${index + 1}: ${open ? "opening" : "shutting"}`);
    run.settle();
  }),
  kidnap: () => simulated((run) => run.command((module) => module.kidnap(), "Kidnapped: the robot was carried elsewhere, and does not know")),
  configure: ({ settings }) => {
    // A robot that the bridge has not named yet gets them too.
    if (conversation) conversation.configure(settings);
    else player.run?.module.configure(settings);
    player.changed();
  },
  twin: ({ on }) => {
    if (conversation) conversation.setTwin(on);
    else player.run?.setTwin(on);
    player.changed();
  },
  connect: ({ url, ...setup }) => converse({ ...setup, goingOn: savedMap.take, title: new URL(url).host }, (module, events) => new BridgeLink(module, url, events)),
  cable: ({ wire, ...setup }) => converse({ ...setup, goingOn: savedMap.take, title: "the cable", token: "" }, (module, events) => new CableLink(module, wire, events)),
  "go-on": ({ name, bytes }) => given(name, () => savedMap.open(name, bytes)),
  "merge-map": ({ name, bytes }) => given(name, () => savedMap.merge(player.run, name, bytes)),
  "prune-map": () => given("", () => savedMap.prune(player.run)),
  "load-map": ({ name, bytes }) => given(name, () => loadedMaps.load(player.run, name, bytes)),
  "load-path": ({ name, bytes }) => given(name, () => loadedMaps.loadPath(player.run, name, bytes)),
  "align-map": ({ id }) => loadedMaps.align(player.run, id),
  "drop-map": ({ id }) => loadedMaps.drop(id),
  "remove-submap": ({ submap }) => renumber((run) => run.removeSubmap(submap)),
  "undo-removal": () => renumber((run) => run.undoRemoval()),
  "begin-at": ({ start }) => savedMap.beginAt(start),
  edit: ({ what, corners }) => changeMap((module) => module.edit(what, new Float64Array(corners)), EDITED[what]),
  "undo-edit": () => changeMap((module) => module.undo_edit(), "The last change of the map by hand is taken back"),
  unplug: () => {
    if (conversation?.link instanceof CableLink) disconnect();
  },
  lease: ({ take, force }) => conversation?.say((module) => (take ? module.take_lease(micros(), force) : module.release_lease(micros()))),
  "reset-bridge-map": () => conversation?.say((module) => module.reset_bridge_map(micros())),
  "set-geofence": ({ zones }) => given("", () => conversation?.say((module) => module.set_geofence(micros(), { zones }))),
  emergency: ({ on }) => conversation?.say((module) => (on ? module.emergency_stop(micros()) : module.reset_emergency_stop(micros()))),
  explore: () => command((run) => run.command((module) => module.explore())),
  manual: () => command((run) => run.command((module) => module.manual())),
  goto: ({ x, y }) => command((run) => run.command((module) => module.go_to(x, y))),
  drive: ({ forward, turn }) => command((run) => run.command((module) => module.drive(forward, turn))),
  stop: () => command((run) => run.command((module) => module.stop(micros()), "Stop")),
  cancel: () => {
    if (interrupt()) return;
    if (player.run?.kind !== "replay") return;
    player.run.cancel();
    player.play(false);
    player.show();
  },
  inspect: attend,
  rooms: attend,
  points: attend,
  wheels: attend,
  field: attend,
  drawn: () => player.drawn(),
};

function attend(what: Watched): void {
  if (player.extras.attend(what)) player.changed();
  else player.show();
}

/** The commands sent while somebody looks around, as in first_visit.mjs; before any other, the rest
    of the module is loaded. */
const OF_A_FIRST_VISIT: ReadonlySet<Command["kind"]> = new Set([
  "start", "speed", "settings", "wheels", "play", "pause", "step", "back", "seek", "drawn", "keep", "inspect", "rooms", "points", "field", "examine",
  "explore", "manual", "goto", "drive", "stop", "cancel", "hold-at", "door", "quality",
] satisfies Command["kind"][]);
const METHODS_OF_A_FIRST_VISIT: readonly string[] = ["scan-matching", "line-ekf"];

function isOfAFirstVisit(command: Command): boolean {
  if (command.kind !== "start") return OF_A_FIRST_VISIT.has(command.kind);
  const { method, worldJson, priorMap, lesson, cycle } = command.setup;
  return METHODS_OF_A_FIRST_VISIT.includes(method) && worldJson === null && priorMap === null && lesson === null && !cycle;
}

let rest: Rest | null = null;

async function load(): Promise<void> {
  rest = new Rest(await init({ module_or_path: new URL("slamlab_web_bg.wasm", self.location.href) }));
}

const module = load();

/** Commands are handled one after the other. */
let before = module;

self.onmessage = ({ data: command }: MessageEvent<Command>) => {
  before = before.then(async () => {
    try {
      await module;
      // If it cannot be loaded, the command is refused, and the run goes on.
      if (!isOfAFirstVisit(command)) await rest?.whole();
      handle(handlers, command);
    } catch (error) {
      // The asking side waits for an answer.
      if (command.kind === "collect") post({ kind: "collected", files: [], error: faultOf(error).text });
      else fail(error);
    }
  }, fail);
};

module.then(() => post({ kind: "ready", ...offer() }), (error: unknown) => {
  fail(new Error(`The simulator could not be loaded: ${faultOf(error).text}. Reload the page.`));
});
