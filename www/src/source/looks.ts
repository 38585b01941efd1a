// What somebody looks at beside the run, worked out only while it is looked at: the inside of the filter, rooms, a field of the grid.

import type { Command } from "../protocol.js";
import type { Inspection } from "../protocol/filter.js";
import type { FieldChange, FieldName } from "../protocol/frame.js";
import type { Rooms } from "../protocol/rooms.js";
import { Sparing } from "./feeds.js";
import type { Source } from "./source.js";

/** Wall milliseconds between two looks into the filter: a matrix is long, and nobody reads faster. */
const INSPECT_MILLIS = 200;

export class Looks {
  #inspecting = { on: false, matrix: false };
  #inspectAt = -Infinity;
  /** Scans that the page has looked into. */
  #inspected = -1;
  #showsRooms = false;
  readonly #rooms = new Sparing<Rooms>();
  #field: FieldName | null = null;
  readonly #fields = new Sparing<FieldChange>();

  /** Another run: all that is looked at is due. */
  anew(): void {
    this.#inspected = -1;
    this.#rooms.refresh();
    this.#fields.refresh();
  }

  /** Looks at something, or away from it; tells whether there is something to show. */
  turn(command: Extract<Command, { kind: "inspect" | "rooms" | "field" }>, source: Source | null): boolean {
    switch (command.kind) {
      case "inspect":
        this.#inspecting = { on: command.on, matrix: command.matrix };
        this.#inspectAt = -Infinity;
        this.#inspected = -1;
        return command.on;
      case "rooms":
        this.#showsRooms = command.on;
        this.#rooms.refresh();
        source?.forgetRooms();
        return command.on;
      case "field":
        this.#field = command.name;
        this.#fields.refresh();
        source?.forgetField();
        return command.name !== null;
    }
  }

  /** What is looked at and due, for a frame. */
  into(source: Source, now: number, playing: boolean): { inspection: Inspection | null; rooms: Rooms | null; field: FieldChange | null } {
    const name = this.#field;
    return {
      inspection: this.#inspect(source, now, playing),
      rooms: this.#showsRooms ? this.#rooms.ask(playing, () => source.rooms()) : null,
      field: name ? this.#fields.ask(playing, () => source.field(name)) : null,
    };
  }

  /** After a scan, but a few times a second at most. */
  #inspect(source: Source, now: number, playing: boolean): Inspection | null {
    if (!this.#inspecting.on || this.#inspected === source.version || (playing && now - this.#inspectAt < INSPECT_MILLIS)) return null;
    this.#inspectAt = now;
    this.#inspected = source.version;
    return source.inspect(this.#inspecting.matrix);
  }
}
