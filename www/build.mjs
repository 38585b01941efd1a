// Bundles the page into dist/: main.js; registration.js and editor.js, which are loaded when the
// lab or the world editor is opened, and files.js when a file of others is; the workers, style.css,
// fonts, the wasm modules and index.html. `node build.mjs` once; `node build.mjs --watch` again at
// every change. The module must stand in pkg/ (cargo xtask run makes it).

import { copyFile, mkdir, readFile, rm, stat } from "node:fs/promises";
import * as esbuild from "esbuild";

const here = new URL("./", import.meta.url);
const at = (path) => new URL(path, here).pathname;
const exists = (path) => stat(path).then(() => true, () => false);

const glue = at("pkg/slamlab_web.js");
if (!(await exists(glue))) {
  console.error("www/pkg/slamlab_web.js is missing: the WebAssembly module is built by `cargo xtask run` (or `cargo xtask test`)");
  process.exit(1);
}

await rm(at("dist"), { recursive: true, force: true });
await mkdir(at("dist"), { recursive: true });

// A component that brings a library's style sheet wants its text, for its own shadow root.
const sheetAsText = {
  name: "sheet-as-text",
  setup(build) {
    build.onLoad({ filter: /uPlot\.min\.css$/ }, async ({ path }) => ({ contents: await readFile(path, "utf8"), loader: "text" }));
  },
};

const options = {
  absWorkingDir: at("."),
  bundle: true,
  format: "esm",
  target: "es2022",
  minify: true,
  sourcemap: true,
  legalComments: "none",
  logLevel: "warning",
  tsconfig: at("tsconfig.json"),
  outdir: at("dist"),
  entryPoints: {
    main: "src/main.ts", registration: "src/registration/lab.ts", editor: "src/editor/editor.ts", style: "src/style.css",
    worker: "src/worker.ts", files: "src/source/files.ts", local_bridge: "src/local_bridge.ts", registration_worker: "src/registration/worker.ts",
  },
  loader: { ".woff2": "file" },
  assetNames: "[name]",
  plugins: [sheetAsText],
};

const statics = async () => {
  await copyFile(at("index.html"), at("dist/index.html"));
  await copyFile(at("icon.svg"), at("dist/icon.svg"));
  for (const module of ["web", "files", "lab", "cable"]) {
    const name = `slamlab_${module}_bg.wasm`;
    await copyFile(at(`pkg/${name}`), at(`dist/${name}`));
  }
};

await statics();
if (process.argv.includes("--watch")) {
  const context = await esbuild.context(options);
  await context.watch();
} else {
  await esbuild.build(options);
}
