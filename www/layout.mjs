// Writes pkg/layout.ts, the layout of the module's flat arrays: which number has which index, as
// reported by the module itself.

import { readFileSync, writeFileSync } from "node:fs";
import { initSync, layout } from "./pkg/slamlab_web.js";

const at = (path) => new URL(path, import.meta.url);

initSync({ module: readFileSync(at("pkg/slamlab_web_bg.wasm")) });
writeFileSync(at("pkg/layout.ts"), layout());
