// The wire to the local bridge, which has devices and rules in a worker of its own (local_bridge.ts): the client's end.
//
// The messages are those of a bridge, so that all that is shown and done is the same.

import type { WebRun } from "../protocol/module.js";
import type { Connection } from "../protocol/devices.js";
import { type LinkEvents, type Link, bridgeState, micros } from "./link.js";

/** Wall milliseconds between two ticks of the pilot. */
const TICK_MILLIS = 50;
const STATE_MILLIS = 250;

export class CableLink implements Link {
  readonly #module: WebRun;
  readonly #wire: MessagePort;
  readonly #events: LinkEvents;
  readonly #ticker: ReturnType<typeof setInterval>;
  #reportedAt = -Infinity;
  /** The rules need a while to load: before they spoke, nobody is silent. */
  #connection: Connection = "connecting";
  #fault = "";

  constructor(module: WebRun, wire: MessagePort, events: LinkEvents) {
    [this.#module, this.#wire, this.#events] = [module, wire, events];
    wire.onmessage = (event: MessageEvent<Uint8Array>) => {
      this.#guard("refused", () => {
        this.#module.receive(micros(), event.data);
        [this.#connection, this.#fault] = ["open", ""];
      });
      this.flush();
      this.#events.moved();
    };
    this.#ticker = setInterval(() => this.#tick(), TICK_MILLIS);
  }

  /** Sends what the module has to say. */
  flush(): void {
    for (let bytes = this.#module.outgoing(); bytes.length > 0; bytes = this.#module.outgoing()) this.#wire.postMessage(bytes, [bytes.buffer]);
  }

  stir(): void {
    this.#reportedAt = -Infinity;
  }

  /** Says farewell: the robot is stopped, and the ports are closed. */
  close(): void {
    clearInterval(this.#ticker);
    this.#wire.onmessage = null;
    this.#wire.postMessage(null);
    this.#wire.close();
  }

  #tick(): void {
    if (this.#connection !== "connecting") this.#guard("lost", () => this.#module.tick(micros()));
    this.flush();
    const now = performance.now();
    if (now - this.#reportedAt >= STATE_MILLIS) {
      this.#reportedAt = now;
      this.#events.state(bridgeState(this.#module, this.#connection, this.#fault));
    }
  }

  /** What fails leaves the connection as it says, until the next message that is understood. */
  #guard(otherwise: "lost" | "refused", act: () => void): void {
    try {
      act();
    } catch (error) {
      this.#connection = otherwise;
      // The module speaks of bridge and network, and there is none.
      this.#fault = otherwise === "lost" ? "The robot's rules in this page have been silent for five seconds." : error instanceof Error ? error.message : String(error);
    }
  }
}
