// Maps and paths of poses that were loaded beside the run: kept here, and aligned with its map on
// request.

import { WebLoadedMap, WebPosePath } from "../../pkg/slamlab_web.js";
import { attempt, post } from "../answer.js";
import type { Run } from "./run.js";

export class LoadedMaps {
  readonly #maps = new Map<number, WebLoadedMap | WebPosePath>();
  #next = 1;

  /** Reads a map, and aligns it. */
  load(run: Run | null, name: string, bytes: ArrayBuffer): void {
    const map = new WebLoadedMap(new Uint8Array(bytes));
    const id = this.#keep(map);
    const picture = map.picture();
    post({ kind: "map-loaded", id, name, picture, path: null }, [picture.walls, picture.way, picture.landmarks].map(({ buffer }) => buffer as ArrayBuffer));
    this.align(run, id);
  }

  /** Reads poses over time, and aligns their path with the trajectory of the run. */
  loadPath(run: Run | null, name: string, bytes: ArrayBuffer): void {
    const path = new WebPosePath(new Uint8Array(bytes));
    const id = this.#keep(path);
    const { way, ...of } = path.picture();
    const none = new Float32Array(0);
    post({ kind: "map-loaded", id, name, picture: { walls: none, way, landmarks: none, points: 0, submaps: 0 }, path: of }, [way.buffer as ArrayBuffer]);
    this.align(run, id);
  }

  #keep(map: WebLoadedMap | WebPosePath): number {
    const id = this.#next;
    this.#next += 1;
    this.#maps.set(id, map);
    return id;
  }

  /** Aligns it with the map as it is drawn now. */
  align(run: Run | null, id: number): void {
    const map = this.#maps.get(id);
    if (!map) return;
    post({ kind: "map-aligned", id, ...attempt("alignment", () => {
      if (!run) throw new Error("There is no map yet.");
      return map instanceof WebPosePath ? run.module.place_path(map) : run.module.align_map(map);
    }) });
  }

  drop(id: number): void {
    this.#maps.get(id)?.free();
    this.#maps.delete(id);
  }
}
