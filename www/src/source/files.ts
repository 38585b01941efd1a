// Foreign files: the module that reads them, in a bundle of its own, which the worker loads when
// such a file is opened.

import init, { WebRosReader, read_building, read_prior_map, solve_graph, check_world, world_file } from "../../pkg/slamlab_files.js";

/** The readers. */
export interface FileModule {
  readonly WebRosReader: typeof WebRosReader;
  readonly read_building: typeof read_building;
  readonly read_prior_map: typeof read_prior_map;
  readonly solve_graph: typeof solve_graph;
  readonly world_file: typeof world_file;
  readonly check_world: typeof check_world;
}

export async function load(): Promise<FileModule> {
  await init({ module_or_path: new URL("slamlab_files_bg.wasm", self.location.href) });
  return { WebRosReader, read_building, read_prior_map, solve_graph, check_world, world_file };
}
