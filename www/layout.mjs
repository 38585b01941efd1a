// Writes pkg/layout.ts: which number stands where in the module's flat arrays, as the module itself
// tells.

import { readFileSync, writeFileSync } from "node:fs";
import { initSync, layout } from "./pkg/slamlab_web.js";

const at = (path) => new URL(path, import.meta.url);

initSync({ module: readFileSync(at("pkg/slamlab_web_bg.wasm")) });
writeFileSync(at("pkg/layout.ts"), layout());
