// Simulates a first visit without a page: runs the page's worker with a module that counts calls,
// sends the commands of a visitor who looks around, and writes the numbers of the functions that
// were called: `node first_visit.mjs COUNTING.wasm CALLED.json`. `cargo xtask build` splits the
// module by this list.

import { readFile, rm, mkdtemp, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import * as esbuild from "esbuild";

const [counting, out] = process.argv.slice(2);
const bytes = await readFile(counting);
const folder = await mkdtemp(join(tmpdir(), "slamlab-first-visit-"));

/** What the page sends its worker on a first visit (src/tour.ts), and on the next one. */
const setup = { worldJson: null, sensor: "lidar", seed: 7, mode: "explore", cycle: false, settings: {}, calibration: null, priorMap: null, lesson: null };
const opened = { inspect: { kind: "inspect", on: true, matrix: true }, rooms: { kind: "rooms", on: true }, points: { kind: "points", on: true } };
const shut = { kind: "inspect", on: false, matrix: false };
const fields = ["distance", "likelihood", "room", null].map((name) => ({ kind: "field", name }));

/** Each runs to its end, or for `until` seconds; `said` lists the commands with their seconds. */
const visits = [
  { setup: { ...setup, world: "loop", method: "scan-matching" }, said: [[0, [{ kind: "wheels", on: true }]]] },
  { setup: { ...setup, world: "office", method: "line-ekf" }, said: [] },
  ...["scan-matching", "line-ekf"].map((method) => ({
    setup: { ...setup, world: "doors", method },
    until: 60,
    said: [
      [2, [opened.inspect, opened.rooms, opened.points, ...fields, shut]],
      [5, [{ kind: "examine", number: 1, x: 0.5, y: 0.5, wall: true }, ...[10, 100, 200, 300].map((beam) => ({ kind: "examine", number: 2, x: 0.5, y: 0.5, beam })), { kind: "examine", number: 3, x: 2, y: 0.5, leaf: [2.2, 0, 2.2, 0.9] }, { kind: "manual" }]],
      [6, [{ kind: "drive", forward: 0.2, turn: 0.3 }]],
      [7, [{ kind: "drive", forward: -0.2, turn: 0 }]],
      [8, [{ kind: "drive", forward: 0, turn: 0 }]],
      [9, [{ kind: "stop" }]],
      [10, [{ kind: "goto", x: 1, y: 0 }]],
      [14, [{ kind: "cancel" }, { kind: "explore" }, { kind: "door", index: 0, open: false }]],
      [20, [{ kind: "door", index: 0, open: true }, { kind: "pause" }, { kind: "step" }, { kind: "step" }, { kind: "back" }, { kind: "play" }]],
      [25, [{ kind: "seek", time: 10 }, { kind: "play" }]],
      [30, [opened.inspect, opened.rooms, opened.points, ...fields, shut, { kind: "quality" }]],
    ],
  })),
  // Somebody takes the wheel in the middle of a leg, drives until a wall stops the robot, stops
  // steering, and then lets it explore again.
  ...["scan-matching", "line-ekf"].flatMap((method) => [1, 2].map((seed) => ({
    setup: { ...setup, world: "office", method, seed },
    until: 60,
    said: [
      [10 + 1.3 * seed, [{ kind: "manual" }]],
      ...Array.from({ length: 20 }, (_, i) => [20 + 0.4 * i, [{ kind: "drive", forward: 0.3, turn: i < 10 ? 0 : 0.2 }]]),
      [40, [{ kind: "explore" }]],
    ],
  }))),
  ...["arena", "corridor", "maze", "lab", "warehouse", "crowd"].map((world) => ({ setup: { ...setup, world, method: "scan-matching" }, until: 5, said: [] })),
  ...["sick", "rangers", "sonar"].map((sensor) => ({ setup: { ...setup, world: "office", sensor, method: "line-ekf" }, until: 5, said: [] })),
];

let exports = null;
WebAssembly.instantiateStreaming = async (_, imports) => {
  const made = await WebAssembly.instantiate(bytes, imports);
  exports = made.instance.exports;
  return made;
};

const listeners = new Map();
const hear = (kind, act) => listeners.set(kind, act);
Object.assign(globalThis, {
  self: globalThis,
  location: new URL("http://localhost/worker.js"),
  // The module is the only thing ever fetched.
  fetch: async () => new Response(),
  postMessage: (answer) => listeners.get(answer.kind)?.(answer),
});
const say = (command) => globalThis.onmessage({ data: structuredClone(command) });

hear("failed", ({ text }) => {
  throw new Error(`a first visit: ${text}`);
});
hear("frame", ({ status }) => {
  say({ kind: "drawn" });
  if (status) seen(status);
});
let seen = () => {};

const worker = join(folder, "worker.mjs");
await esbuild.build({ entryPoints: [new URL("src/worker.ts", import.meta.url).pathname], bundle: true, format: "esm", target: "es2022", outfile: worker, logLevel: "warning" });
const ready = new Promise((resolve) => hear("ready", resolve));
await import(pathToFileURL(worker));
await ready;
for (const { setup, until = Infinity, said } of visits) {
  const left = [...said];
  // The run waits at each of these moments, so that the calls do not depend on wall-clock time.
  const hold = () => say({ kind: "hold-at", time: left[0]?.[0] ?? until });
  say({ kind: "speed", factor: Infinity });
  say({ kind: "start", setup, play: true });
  say({ kind: "settings", settings: {} });
  hold();
  await new Promise((resolve) => {
    seen = ({ time, finished }) => {
      if (left.length > 0 && left[0][0] <= time) {
        left.shift()[1].forEach(say);
        hold();
      } else if (finished || time >= until) resolve();
    };
  });
  seen = () => {};
  const kept = new Promise((resolve) => hear("kept", resolve));
  say({ kind: "keep", setup });
  await kept;
}
const called = Object.entries(exports)
  .filter(([name, mark]) => name.startsWith("called ") && mark.value === 1)
  .map(([name]) => Number(name.slice("called ".length)));
await writeFile(out, JSON.stringify(called));
await rm(folder, { recursive: true });
process.exit(0);
