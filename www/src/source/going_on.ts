// The saved map that runs by scan matching go on in: opened, merged with others, pruned, saved.

import { type WebRun, WebSavedMap } from "../../pkg/slamlab_web.js";
import { post } from "../answer.js";
import type { MapStart, SavedFile } from "../protocol/module.js";
import type { Run } from "./run.js";

export class GoingOn {
  #map: WebSavedMap | null = null;
  #name = "";
  /** Where in the map the robot is when a run begins. */
  #start: MapStart = { from: "left" };
  /** Whether the present run, if by scan matching, began in the map, and so contains more. */
  #isBegun = false;

  /** The run, in the saved map if its method can go on in one. */
  readonly take = (run: WebRun): WebRun => {
    if (this.#map && run.method() === "scan-matching") {
      run.go_on_in(this.#map, this.#start);
      this.#isBegun = true;
    }
    return run;
  };

  beginAt(start: MapStart): void {
    this.#start = start;
  }

  /** Runs go on in the map of this file from the next run on; without bytes, in none. */
  open(name: string, bytes: ArrayBuffer | null): void {
    const next = bytes && new WebSavedMap(new Uint8Array(bytes));
    this.#keep(next, next ? name : "");
    this.#tell(true, next ? `Goes on in the map ${name}: where the robot was left, or wherever it finds itself` : "Begins with an empty map");
  }

  /** Merges the map of this file into the present one. */
  merge(run: Run | null, name: string, bytes: ArrayBuffer): void {
    const { map, title } = this.#base(run);
    try {
      this.#keep(map.merged(new Uint8Array(bytes)), `${stem(title)} and ${stem(name)}`);
    } finally {
      if (map !== this.#map) map.free();
    }
    this.#tell(false, `${title} and ${name} are one map now`);
  }

  /** Prunes the present map: removes what newer parts of it cover. */
  prune(run: Run | null): void {
    const { map, title } = this.#base(run);
    const { submaps, keyframes } = map.prune();
    if (map !== this.#map) this.#keep(map, stem(title));
    this.#isBegun = false;
    this.#tell(false, submaps > 0 ? `Taken out of ${title}: ${submaps} submaps with ${keyframes} keyframes` : `Nothing was taken out of ${title}: no part of it is covered by newer ones`);
  }

  /** The map as it was opened, merged or pruned. */
  files(): SavedFile[] {
    return this.#map ? [this.#map.file(stem(this.#name).replace(/[^\w-]+/g, "-"))] : [];
  }

  /** The map drawn by the present run, which contains the saved map that it began in. If the run is
      not by scan matching, or there is a newer saved map: the saved map. */
  #base(run: Run | null): { map: WebSavedMap; title: string } {
    const isDrawn = run?.module.method() === "scan-matching" && (!this.#map || this.#isBegun);
    if (this.#map && !isDrawn) return { map: this.#map, title: this.#name };
    if (!run) throw new Error("There is no map yet.");
    return { map: run.module.as_saved_map(run.title), title: run.title };
  }

  #keep(map: WebSavedMap | null, name: string): void {
    if (this.#map !== map) this.#map?.free();
    this.#map = map;
    this.#name = name;
    this.#start = { from: "left" };
    this.#isBegun = false;
  }

  #tell(begins: boolean, told: string): void {
    const picture = this.#map?.picture() ?? null;
    post({ kind: "going-on", name: this.#name, picture, begins, told }, picture?.grid ? [picture.grid.cells.buffer as ArrayBuffer] : []);
  }
}

function stem(name: string): string {
  return name.replace(/\.[a-z]+$/i, "");
}
