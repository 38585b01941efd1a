// Bundles the page into dist/: main.js and the parts that are loaded on demand; the workers;
// offline_worker.js, which keeps all of it for use without a server (not with --watch); style.css,
// fonts, icons, the wasm modules and index.html. `node build.mjs` builds once;
// `node build.mjs --watch` again after every change. The module must be in pkg/ (cargo xtask run
// puts it there).
//
// | bundle | loaded when |
// |---|---|
// | plotter.js | the first plot is seen |
// | panels.js | the tab of filter, paths or settings is chosen, or the fold of maps opened |
// | inspector.js | something is inspected |
// | race.js | a run is compared with others |
// | bridge_map.js | the bridge maps, too |
// | bridge_field.js | somebody looks for a robot behind a bridge |
// | recordings.js | somebody looks at the recordings of the bridge |
// | registration.js, editor.js | the lab or the world editor is opened |
// | saving.js | somebody wants to save something |
// | archive.js | a ZIP archive is opened |
// | files.js | a file in a foreign format is opened |
// | svg_context.js | the view is saved as a drawing |
// | language.js | the help is opened, where the language is chosen |
// | words_hu.js … | a language other than English is chosen |
// | fleet.js | fleet.html is opened: all robots behind a router |
// | gl.js | a graphics card is available to draw the map |

import { createHash } from "node:crypto";
import { copyFile, cp, mkdir, readdir, readFile, rm, stat } from "node:fs/promises";
import { join, relative } from "node:path";
import * as esbuild from "esbuild";

const here = new URL("./", import.meta.url);
const at = (path) => new URL(path, here).pathname;
/** Hexadecimal digits kept of a hash: too many for two contents to share them by chance. */
const HASH_DIGITS = 16;
const exists = (path) => stat(path).then(() => true, () => false);

const glue = at("pkg/slamlab_web.js");
if (!(await exists(glue))) {
  console.error("www/pkg/slamlab_web.js is missing: the WebAssembly module is built by `cargo xtask run` (or `cargo xtask test`)");
  process.exit(1);
}

await rm(at("dist"), { recursive: true, force: true });
await mkdir(at("dist"), { recursive: true });

// A component imports a library's style sheet as text, for its own shadow root.
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
    main: "src/main.ts", registration: "src/registration/lab.ts", fleet: "src/fleet/fleet.ts", editor: "src/editor/editor.ts", inspector: "src/inspector/panel.ts", svg_context: "src/view/svg_context.ts", gl: "src/view/gl/surface.ts", race: "src/race/race.ts", panels: "src/ui/panels.ts", plotter: "src/ui/plotter.ts", bridge_map: "src/ui/bridge_map.ts", recordings: "src/ui/recordings.ts", bridge_field: "src/ui/bridge_field.ts", saving: "src/ui/saving.ts", archive: "src/ui/archive.ts", zip_worker: "src/zip_worker.ts",
    language: "src/ui/language.ts", words_hu: "src/words/hu.ts", words_cs: "src/words/cs.ts", words_pl: "src/words/pl.ts", style: "src/style.css",
    worker: "src/worker.ts", files: "src/source/files.ts", local_bridge: "src/local_bridge.ts", registration_worker: "src/registration/worker.ts",
  },
  loader: { ".woff2": "file" },
  assetNames: "[name]",
  plugins: [sheetAsText],
};

const statics = async () => {
  await copyFile(at("index.html"), at("dist/index.html"));
  await copyFile(at("fleet.html"), at("dist/fleet.html"));
  await copyFile(at("icon.svg"), at("dist/icon.svg"));
  await copyFile(at("manifest.webmanifest"), at("dist/manifest.webmanifest"));
  await cp(at("icons"), at("dist/icons"), { recursive: true });
  await mkdir(at("dist/examples"), { recursive: true });
  await copyFile(at("examples/ring.gzip"), at("dist/examples/ring.gzip"));
  for (const module of ["web", "files", "lab", "cable"]) {
    const name = `slamlab_${module}_bg.wasm`;
    await copyFile(at(`pkg/${name}`), at(`dist/${name}`));
  }
  // Two parts, if the module was split.
  if (await exists(at("pkg/split"))) await cp(at("pkg/split"), at("dist"), { recursive: true });
};

await statics();
if (process.argv.includes("--watch")) {
  const context = await esbuild.context(options);
  await context.watch();
} else {
  await esbuild.build(options);
  await bundleOfflineWorker();
}

/** The service worker, which knows the name and content hash of every file that the page may load.
    There is none with --watch, so that changes show at once. */
async function bundleOfflineWorker() {
  const names = (await readdir(at("dist"), { recursive: true, withFileTypes: true }))
    .filter((entry) => entry.isFile() && !entry.name.endsWith(".map"))
    .map((entry) => relative(at("dist"), join(entry.parentPath ?? entry.path, entry.name)).replaceAll("\\", "/"))
    .sort();
  const files = {};
  const build = createHash("sha256");
  for (const name of names) {
    const hash = createHash("sha256").update(await readFile(at(`dist/${name}`))).digest("hex").slice(0, HASH_DIGITS);
    // Servers serve index.html under the name of its folder.
    const path = name === "index.html" ? "" : name;
    files[path] = hash;
    build.update(`${path} ${hash}\n`);
  }
  await esbuild.build({
    ...options,
    entryPoints: { offline_worker: "src/offline_worker/main.ts" },
    define: { FILES: JSON.stringify(files), BUILD: JSON.stringify(build.digest("hex").slice(0, HASH_DIGITS)) },
  });
}
