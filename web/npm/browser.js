import { start } from "./glue.js";

// Written out, for bundlers to find.
const WASM = {
  run: () => new URL("./slamlab_web_bg.wasm", import.meta.url),
  files: () => new URL("./slamlab_files_bg.wasm", import.meta.url),
  lab: () => new URL("./slamlab_lab_bg.wasm", import.meta.url),
  cable: () => new URL("./slamlab_cable_bg.wasm", import.meta.url),
};

export const load = (name = "run", wasm) => start(name, () => wasm ?? WASM[name]());
