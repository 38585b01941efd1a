// Maps that were loaded beside the run: kept here, and laid on its map when that is asked for.

import { WebLoadedMap } from "../../pkg/slamlab_web.js";
import { attempt, post } from "../answer.js";
import type { Run } from "./run.js";

export class LoadedMaps {
  readonly #maps = new Map<number, WebLoadedMap>();
  #next = 1;

  /** Reads a map, and looks where it lies. */
  load(run: Run | null, name: string, bytes: ArrayBuffer): void {
    const map = new WebLoadedMap(new Uint8Array(bytes));
    const id = this.#next;
    this.#next += 1;
    this.#maps.set(id, map);
    const picture = map.picture();
    post({ kind: "map-loaded", id, name, picture }, [picture.walls, picture.way, picture.landmarks].map(({ buffer }) => buffer as ArrayBuffer));
    this.align(run, id);
  }

  /** Looks where it lies in the map as it is drawn now. */
  align(run: Run | null, id: number): void {
    const map = this.#maps.get(id);
    if (!map) return;
    post({ kind: "map-aligned", id, ...attempt("alignment", () => {
      if (!run) throw new Error("There is no map yet.");
      return run.module.align_map(map);
    }) });
  }

  drop(id: number): void {
    this.#maps.get(id)?.free();
    this.#maps.delete(id);
  }
}
