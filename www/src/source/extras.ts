// Data computed only while shown: the filter's state, rooms, points of the scan, the map by
// odometry alone, a field of the grid.

import type { Command } from "../protocol.js";
import type { Requested } from "../protocol/frame.js";
import type { FieldName, Inspection, WebRun } from "../protocol/module.js";
import { Sparing } from "./feeds.js";
import type { Run } from "./run.js";

/** Wall milliseconds between two inspections of the filter: a matrix is long, and nobody reads
    faster. */
const INSPECT_MILLIS = 200;

export type Watched = Extract<Command, { kind: "inspect" | "rooms" | "points" | "wheels" | "field" }>;

export class Extras {
  #inspecting = { on: false, matrix: false };
  #inspectAt = -Infinity;
  /** The version of the run that was last inspected. */
  #inspected = -1;
  #showsRooms = false;
  readonly #rooms = new Sparing();
  #showsPoints = false;
  /** The version of the run whose points were last sent. */
  #pointsOf = -1;
  #showsWheels = false;
  readonly #wheels = new Sparing();
  #field: FieldName | null = null;
  readonly #fields = new Sparing();

  /** Another run: everything is sent again. */
  reset(): void {
    this.#inspected = this.#pointsOf = -1;
    this.#rooms.refresh();
    this.#wheels.refresh();
    this.#fields.refresh();
  }

  /** Starts or stops showing something; returns whether there is something to show. */
  attend(what: Watched): boolean {
    switch (what.kind) {
      case "inspect":
        this.#inspecting = what;
        this.#inspectAt = -Infinity;
        this.#inspected = -1;
        return what.on;
      case "rooms":
        this.#showsRooms = what.on;
        this.#rooms.refresh();
        return what.on;
      case "points":
        this.#showsPoints = what.on;
        this.#pointsOf = -1;
        return what.on;
      case "wheels":
        this.#showsWheels = what.on;
        this.#wheels.refresh();
        return what.on;
      case "field":
        this.#field = what.name;
        this.#fields.refresh();
        return what.name !== null;
    }
  }

  /** The extras that are due, for a frame. */
  of(run: Run, now: number, playing: boolean): Requested {
    const { module } = run;
    return {
      inspection: this.#inspect(run, now, playing),
      rooms: this.#showsRooms ? this.#rooms.ask(playing, (known) => module.rooms(known.generation, known.revision)) : null,
      points: this.#showsPoints ? this.#pointsFound(run) : null,
      wheels: this.#showsWheels ? this.#wheelsOf(module, playing) : null,
      field: this.#field ? this.#fieldOf(module, this.#field, playing) : null,
    };
  }

  /** A field of the grid, if it may have changed. */
  #fieldOf(module: WebRun, name: FieldName, playing: boolean): Requested["field"] {
    const field = this.#fields.ask(playing, ({ generation, revision }) => {
      const found = module.field(name, generation, revision);
      return { ...found, reset: found.generation !== generation };
    });
    return field && (field.grid || field.reset) ? field : null;
  }

  /** The map by odometry alone, if it changed. */
  #wheelsOf(module: WebRun, playing: boolean): Requested["wheels"] {
    return this.#wheels.ask(playing, ({ revision }) => module.dead_reckoned(revision))?.grid ?? null;
  }

  /** Once after each scan. */
  #pointsFound(run: Run): Float32Array | null {
    if (this.#pointsOf === run.version) return null;
    this.#pointsOf = run.version;
    return run.module.points_found();
  }

  /** Once after each scan, but at most a few times a second. */
  #inspect(run: Run, now: number, playing: boolean): Inspection | null {
    if (!this.#inspecting.on || this.#inspected === run.version || (playing && now - this.#inspectAt < INSPECT_MILLIS)) return null;
    this.#inspectAt = now;
    this.#inspected = run.version;
    return run.module.inspect(this.#inspecting.matrix) ?? null;
  }
}
