// What is computed only while it is shown: the filter's state, rooms, a field of the grid.

import type { Command } from "../protocol.js";
import type { Requested } from "../protocol/frame.js";
import type { FieldName, Inspection, Rooms } from "../protocol/module.js";
import { Sparing } from "./feeds.js";
import type { Run } from "./run.js";

/** Wall milliseconds between two inspections of the filter: a matrix is long, and nobody reads
    faster. */
const INSPECT_MILLIS = 200;

export class Extras {
  #inspecting = { on: false, matrix: false };
  #inspectAt = -Infinity;
  /** The version of the run that was inspected last. */
  #inspected = -1;
  #showsRooms = false;
  readonly #rooms = new Sparing<Rooms>();
  #field: FieldName | null = null;
  readonly #fields = new Sparing<NonNullable<Requested["field"]>>();

  /** Another run: everything is due. */
  reset(): void {
    this.#inspected = -1;
    this.#rooms.refresh();
    this.#fields.refresh();
  }

  /** Starts or stops showing something; returns whether there is something to show. */
  attend(command: Extract<Command, { kind: "inspect" | "rooms" | "field" }>, run: Run | null): boolean {
    switch (command.kind) {
      case "inspect":
        this.#inspecting = { on: command.on, matrix: command.matrix };
        this.#inspectAt = -Infinity;
        this.#inspected = -1;
        return command.on;
      case "rooms":
        this.#showsRooms = command.on;
        this.#rooms.refresh();
        run?.forgetRooms();
        return command.on;
      case "field":
        this.#field = command.name;
        this.#fields.refresh();
        run?.forgetField();
        return command.name !== null;
    }
  }

  /** What is due, for a frame. */
  of(run: Run, now: number, playing: boolean): Requested {
    const name = this.#field;
    return {
      inspection: this.#inspect(run, now, playing),
      rooms: this.#showsRooms ? this.#rooms.ask(playing, () => run.rooms()) : null,
      field: name ? this.#fields.ask(playing, () => run.field(name)) : null,
    };
  }

  /** After a scan, but a few times a second at most. */
  #inspect(run: Run, now: number, playing: boolean): Inspection | null {
    if (!this.#inspecting.on || this.#inspected === run.version || (playing && now - this.#inspectAt < INSPECT_MILLIS)) return null;
    this.#inspectAt = now;
    this.#inspected = run.version;
    return run.inspect(this.#inspecting.matrix);
  }
}
