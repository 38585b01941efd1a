// Makes a first visit without a page, and the next one: runs the worker of the page with a module
// that marks what is called, and writes the numbers of the functions that were: `node
// first_visit.mjs COUNTING.wasm CALLED.json`. `cargo xtask build` splits the module by them.

import { readFile, rm, mkdtemp, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import * as esbuild from "esbuild";

const [counting, out] = process.argv.slice(2);
const bytes = await readFile(counting);
const folder = await mkdtemp(join(tmpdir(), "slamlab-first-visit-"));

/** What the page says to its worker on a first visit (src/tour.ts), and on the next one. */
const setup = { worldJson: null, sensor: "lidar", seed: 7, mode: "explore", cycle: false, settings: {}, calibration: null, priorMap: null, lesson: null };
const visits = [
  { setup: { ...setup, world: "loop", method: "scan-matching" }, during: [{ kind: "wheels", on: true }] },
  { setup: { ...setup, world: "office", method: "line-ekf" }, during: [] },
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
  // Whatever is fetched is the module.
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
for (const { setup, during } of visits) {
  say({ kind: "speed", factor: Infinity });
  say({ kind: "start", setup, play: true });
  say({ kind: "settings", settings: {} });
  during.forEach(say);
  await new Promise((resolve) => {
    seen = (status) => {
      if (status.finished) resolve();
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
