import type * as Cable from "./slamlab_cable.js";
import type * as Files from "./slamlab_files.js";
import type * as Lab from "./slamlab_lab.js";
import type * as Run from "./slamlab_web.js";

/** What can be loaded; each is a module of WebAssembly, and they share no memory. */
export interface Modules {
  /** Runs of any source, simulated or recorded, and what is asked of them. 3.7 MB. */
  run: Omit<typeof Run, "default" | "initSync">;
  /** Files of others: buildings, pose graphs, recordings of ROS. 1.3 MB. */
  files: Omit<typeof Files, "default" | "initSync">;
  /** Registration of two scans by every method. 0.6 MB. */
  lab: Omit<typeof Lab, "default" | "initSync">;
  /** Protocols of robots and lidars, and the rules of safety of a bridge. 0.3 MB. */
  cable: Omit<typeof Cable, "default" | "initSync">;
}

/**
 * Loads a module, once however often it is asked for.
 *
 * @param wasm Its code, where it does not lie beside this package's files: an address, a response
 * or bytes.
 * @throws RangeError if there is no such module.
 */
export function load<Name extends keyof Modules = "run">(
  name?: Name,
  wasm?: string | URL | Request | Response | BufferSource | WebAssembly.Module,
): Promise<Modules[Name]>;

export type * from "./slamlab_web.js";
