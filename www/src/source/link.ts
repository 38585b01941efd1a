// The client's end of a connection to a robot: sends the module's bytes, drives its clock, and
// reports the state of both.

import type { WebRun } from "../protocol/module.js";
import type { BridgeState, Connection } from "../protocol/devices.js";

/** Wall milliseconds between two ticks of the pilot. */
const TICK_MILLIS = 50;
const STATE_MILLIS = 250;

export interface LinkEvents {
  /** A message came, or time passed: the run may have changed. */
  moved(): void;
  /** The state of bridge and robot, a few times a second; with the walls of the bridge's own map if
      they changed. */
  state(state: BridgeState, walls: Float32Array | null): void;
}

/** µs of this page's clock. */
export function micros(): number {
  return performance.now() * 1000;
}

/** The connection to a bridge, or to devices of this very computer. */
export abstract class Link {
  protected connection: Connection = "connecting";
  protected fault = "";
  readonly #ticker: ReturnType<typeof setInterval>;
  #reportedAt = -Infinity;
  #revision = 0;

  constructor(protected readonly module: WebRun, protected readonly events: LinkEvents) {
    this.#ticker = setInterval(() => {
      this.tick();
      this.report();
    }, TICK_MILLIS);
  }

  /** Lets the module decide, if the connection is open. */
  protected abstract tick(): void;

  protected abstract send(bytes: Uint8Array<ArrayBuffer>): void;

  /** Sends the module's messages. */
  flush(): void {
    for (const bytes of this.module.outgoing()) this.send(bytes as Uint8Array<ArrayBuffer>);
  }

  /** Reports the state at the next tick. */
  stir(): void {
    this.#reportedAt = -Infinity;
  }

  close(): void {
    clearInterval(this.#ticker);
  }

  protected report(): void {
    const now = performance.now();
    if (now - this.#reportedAt < STATE_MILLIS) return;
    this.#reportedAt = now;
    const { connection, fault, module } = this;
    const state = { ...module.bridge(), connection, fault };
    const revision = state.map?.revision ?? 0;
    const walls = revision === this.#revision ? null : module.bridge_map_walls();
    this.#revision = revision;
    this.events.state(state, walls);
  }
}
