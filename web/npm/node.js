// Node's fetch knows no files.
import { readFile } from "node:fs/promises";
import { start } from "./glue.js";

const FILES = { run: "web", files: "files", lab: "lab", cable: "cable" };

export const load = (name = "run", wasm) => start(name, () => wasm ?? readFile(new URL(`./slamlab_${FILES[name]}_bg.wasm`, import.meta.url)));
