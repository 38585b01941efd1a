// Runs the core for the page: with local_bridge.ts the only file that starts the WebAssembly module.
//
// It paces the source (simulated seconds for each second), works in slices short enough that every message is heard within
// about 20 ms, and sends a frame only when the page has drawn the one before.

import init, { WebExperiment, WebLive, data_sheet, device_kinds, preset_list, sensor_names, world_names } from "../pkg/slamlab_web.js";
import { fail, post, refuse, wordsOf } from "./answer.js";
import type { Answer, Command } from "./protocol.js";
import type { DeviceKind } from "./protocol/devices.js";
import { transferables } from "./protocol/frame.js";
import type { KnownMap, MethodName, Named, SettingValues } from "./protocol/setup.js";
import { BridgeSource } from "./source/bridge.js";
import { build, know, knownOf, setupOf } from "./source/building.js";
import { listOf, presetOf } from "./source/convert.js";
import { CableLink } from "./source/cable.js";
import { BridgeLink, type Link, type LinkEvents } from "./source/link.js";
import { ContestRunner } from "./source/contest.js";
import { answerOf } from "./source/figures.js";
import { Looks } from "./source/looks.js";
import { Pace } from "./source/pace.js";
import { LogReading } from "./source/reading.js";
import { ReplaySource } from "./source/replay.js";
import { SimSource } from "./source/sim.js";
import type { Source } from "./source/source.js";

/** Wall milliseconds between two looks when there is nothing to do yet. */
const IDLE_MILLIS = 6;
/** Wall milliseconds that one turn may take before it looks for messages. */
const SLICE_MILLIS = 12;
const HASH_MILLIS = 500;

let reading: LogReading | null = null;

let source: Source | null = null;
/** What is known better of a robot than it says itself. */
let told: { settings: SettingValues; twin: boolean } = { settings: {}, twin: false };
let contest: ContestRunner | null = null;
let run = 0;
let seq = 0;
let playing = false;
/** The page has drawn the last frame and can take another. */
let pageReady = true;
/** Something changed that no frame has shown. */
let stale = false;
const pace = new Pace();
let hashAt = -Infinity;
const looks = new Looks();
let scheduled = false;
const immediate = new MessageChannel();
immediate.port1.onmessage = () => turn();

function schedule(now: boolean): void {
  if (scheduled || !(playing || reading)) return;
  scheduled = true;
  if (now) immediate.port2.postMessage(null);
  else setTimeout(turn, IDLE_MILLIS);
}

function rebase(): void {
  pace.rebase(performance.now(), source?.time ?? 0);
}

/** One slice of work. */
function turn(): void {
  scheduled = false;
  if (reading) {
    readOn(reading);
    return;
  }
  // A robot behind a bridge goes at its own pace: its link tells when something came.
  if (!source || !playing || source.kind === "bridge") return;
  try {
    const begin = performance.now();
    const target = pace.target(begin);
    let behind = false;
    while (source.time < target && !source.finished) {
      source.step();
      stale = true;
      behind = performance.now() - begin >= SLICE_MILLIS;
      if (behind) break;
    }
    if (behind) pace.fallBehind(begin, source.time);
    pace.measure(performance.now(), source.time);
    if (source.finished) setPlaying(false);
    show();
    schedule(behind);
  } catch (error) {
    fail(error);
  }
}

/** One slice of reading; at the end of the log its replay begins. */
function readOn(log: LogReading): void {
  try {
    const replay = log.readOn(SLICE_MILLIS);
    if (replay) {
      reading = null;
      begin(new ReplaySource(replay, log.name, log.method), { setup: null, playing: true });
    }
  } catch (error) {
    stopReading();
    refuse(log.name, error);
  }
  schedule(true);
}

function stopReading(): void {
  if (reading) {
    reading.free();
    reading = null;
  }
  post({ kind: "reading", name: "", done: null });
  rebase();
  schedule(true);
}

function setPlaying(next: boolean): void {
  if (next !== playing) {
    playing = next;
    post({ kind: "playing", playing });
  }
  rebase();
  hashAt = -Infinity;
  stale = true;
  schedule(true);
}

/** Sends a frame if the page can take one. */
function show(): void {
  if (!source) return;
  for (const note of source.notes()) post({ kind: "event", run, ...note });
  const now = performance.now();
  if (now - hashAt >= HASH_MILLIS) {
    hashAt = now;
    post({ kind: "hash", run, text: source.hash() });
  }
  if (!pageReady || !stale) return;
  pageReady = false;
  stale = false;
  seq += 1;
  // The numbers of the moment count what the change has just fetched.
  const change = source.change();
  const moment = source.moment();
  const elapsed = source.kind === "replay" ? (performance.now() - began) / 1000 : NaN;
  const remaining = moment.progress > 0.005 ? (elapsed * (1 - moment.progress)) / moment.progress : NaN;
  const status = { ...moment, realTimeFactor: playing ? pace.factor : NaN, remaining };
  const clock = pace.clock(playing && source.kind !== "bridge");
  const frame = { kind: "frame", run, seq, clock, status, ...change, ...looks.into(source, now, playing) } as const;
  post(frame, transferables(frame));
}

/** Wall ms at which the present run began. */
let began = 0;

/** The bridge that is being talked to; its run begins when it has said who it is. */
let live: { link: Link; module: WebLive } | null = null;

/** Begins a conversation; its run begins when the other end has said who it is. */
function converse({ token = "", method, known }: { token?: string; method: MethodName; known: KnownMap | null }, title: string, wire: (module: WebLive, events: LinkEvents) => Link): void {
  disconnect();
  const module = new WebLive(navigator.userAgent.includes("Mobile") ? "phone" : "browser", token, method, 1, known && method === "known-map" ? knownOf(known) : undefined);
  // The other end may speak while its link is being made.
  let link: Link | null = null;
  link = wire(module, {
    moved: () => {
      if (!link) return;
      const shown = source instanceof BridgeSource ? source : null;
      if (module.begun() !== (shown?.begun ?? 0)) {
        // The module and its link go on in the new run.
        if (shown) source = null;
        const next = new BridgeSource(module, link, title, method);
        next.tell(told.settings, told.twin);
        begin(next, { setup: null, playing: true });
      }
      if (!(source instanceof BridgeSource)) return;
      source.moved();
      stale = true;
      show();
    },
    state: (state) => post({ kind: "bridge", state }),
  });
  live = { link, module };
}

/** Leaves the bridge; its run, if one shows it, ends with the next that begins. */
function disconnect(): void {
  if (!live) return;
  const { link, module } = live;
  live = null;
  if (source instanceof BridgeSource) {
    source = null;
  }
  link.close();
  module.free();
  post({ kind: "bridge", state: null });
}

/** Takes a new source only once it exists: a setup that fails leaves the old run as it is. */
function begin(next: Source, answer: Omit<Extract<Answer, { kind: "started" }>, "kind" | "run" | "source" | "title" | "method">): void {
  if (!(next instanceof BridgeSource)) disconnect();
  contest?.close();
  source?.close();
  source = next;
  looks.anew();
  run += 1;
  seq = 0;
  stale = true;
  hashAt = -Infinity;
  began = performance.now();
  playing = answer.playing;
  post({ kind: "started", run, source: next.kind, title: next.title, method: next.method, ...answer });
  rebase();
  pageReady = true;
  show();
  schedule(true);
}

function handle(command: Command): void {
  const sim = source instanceof SimSource ? source : null;
  const bridge = source instanceof BridgeSource ? source : null;
  switch (command.kind) {
    case "start": {
      if (reading) stopReading();
      const { setup } = command;
      try {
        begin(new SimSource(new WebExperiment(setupOf(setup)), setup), { setup, playing: command.play });
      } catch (error) {
        refuse(setup.worldJson === null ? "" : setup.world, error);
      }
      break;
    }
    case "build":
      try {
        build(command.name, command.files);
      } catch (error) {
        refuse(command.name, error);
      }
      break;
    case "know":
      try {
        know(command.name, command.files, source);
      } catch (error) {
        refuse(command.name, error);
      }
      break;
    case "replay":
      if (reading) stopReading();
      reading = new LogReading(command, told);
      schedule(true);
      break;
    case "play":
      if (source && !source.finished) setPlaying(true);
      break;
    case "pause":
      setPlaying(false);
      show();
      break;
    case "step": {
      setPlaying(false);
      const scans = source?.scans ?? 0;
      for (let i = 0; source && i < 400 && source.scans === scans && !source.finished; i += 1) source.step();
      show();
      break;
    }
    case "speed":
      pace.speed = command.factor;
      rebase();
      schedule(true);
      break;
    case "stage":
      setPlaying(false);
      sim?.nextStage();
      stale = true;
      show();
      break;
    case "cycle":
      if (!sim) break;
      sim.setCycle(command.on);
      stale = true;
      show();
      break;
    case "configure":
      sim?.configure(...listOf(command.settings));
      break;
    case "settings":
    case "calibrate":
    case "sigma":
    case "fit":
    case "preset":
    case "bench":
    case "save":
      answerOf(command, source);
      break;
    case "tell":
      bridge?.tell(command.settings, command.twin);
      told = { settings: command.settings, twin: command.twin };
      stale = true;
      show();
      break;
    case "connect":
      if (reading) stopReading();
      converse(command, new URL(command.url).host, (module, events) => new BridgeLink(module, command.url, events));
      break;
    case "cable":
      if (reading) stopReading();
      converse(command, "the cable", (module, events) => new CableLink(module, command.wire, events));
      break;
    case "unplug":
      if (live?.link instanceof CableLink) disconnect();
      break;
    case "wheel":
      bridge?.wheel(command.take, command.force);
      break;
    case "door":
      if (!sim) break;
      sim.setDoor(command.index, command.open);
      stale = true;
      show();
      break;
    case "emergency":
      bridge?.emergency(command.on);
      break;
    case "explore":
    case "manual":
    case "goto":
    case "drive":
    case "stop": {
      const robot = sim ?? bridge;
      if (!robot) break;
      if (command.kind === "explore") robot.explore();
      else if (command.kind === "manual") robot.manual();
      else if (command.kind === "goto") robot.goTo(command.x, command.y);
      else if (command.kind === "drive") robot.drive(command.forward, command.turn);
      else robot.stop();
      stale = true;
      show();
      break;
    }
    case "cancel":
      if (reading) {
        stopReading();
      } else if (source instanceof ReplaySource) {
        source.cancel();
        setPlaying(false);
        show();
      }
      break;
    case "inspect":
    case "rooms":
    case "field":
      if (looks.turn(command, source)) stale = true;
      show();
      break;
    case "contest": {
      const { ask, watched } = command;
      const asked = source;
      if (!asked) break;
      contest ??= new ContestRunner(post);
      try {
        contest.begin(ask, watched, () => asked.contest(ask));
      } catch (error) {
        post({ kind: "contest", contest: null, error: wordsOf(error) });
      }
      break;
    }
    case "contest-watch":
      contest?.watch(command.watched);
      break;
    case "contest-stop":
      contest?.stop();
      break;
    case "drawn":
      pageReady = true;
      if (stale) show();
      break;
  }
}

const module = init({ module_or_path: new URL("slamlab_web_bg.wasm", self.location.href) });

self.onmessage = async (event: MessageEvent<Command>) => {
  try {
    await module;
    handle(event.data);
  } catch (error) {
    fail(error);
  }
};

/** Names and titles come from the module one after the other. */
function sensors(): Named[] {
  const names = sensor_names();
  return names.flatMap((name, i) => (i % 2 === 0 ? [{ name, title: names[i + 1] ?? name }] : []));
}

/** Adapters come as vendor and product one after the other. */
function devices(): DeviceKind[] {
  return device_kinds().map((kind) => {
    const { name, title, about, adapters } = kind;
    kind.free();
    return { name, title, about, adapters: [...adapters].flatMap((usbVendorId, i) => (i % 2 === 0 ? [{ usbVendorId, usbProductId: adapters[i + 1] ?? 0 }] : [])) };
  });
}

module.then(() => post({ kind: "ready", worlds: world_names(), sensors: sensors(), devices: devices(), presets: preset_list().map(presetOf), dataSheet: data_sheet() }), (error: unknown) => {
  fail(new Error(`The simulator could not be loaded: ${wordsOf(error)}. Reload the page.`));
});
