// The modules' bindings; each is loaded when it is asked for.
const GLUE = {
  run: () => import("./slamlab_web.js"),
  files: () => import("./slamlab_files.js"),
  lab: () => import("./slamlab_lab.js"),
  cable: () => import("./slamlab_cable.js"),
};

export async function start(name, wasm) {
  if (!Object.hasOwn(GLUE, name)) throw new RangeError(`there is no module ${name}; expected one of ${Object.keys(GLUE).join(", ")}`);
  const module = await GLUE[name]();
  await module.default({ module_or_path: await wasm(name) });
  return module;
}
