// The connection to the local bridge, which has devices and rules in a worker of its own
// (local_bridge.ts). It uses the messages of any bridge, so that everything is shown and done in
// the same way.

import { faultOf } from "../fault.js";
import type { WebRun } from "../protocol/module.js";
import { Link, type LinkEvents, micros } from "./link.js";

export class CableLink extends Link {
  constructor(module: WebRun, private readonly wire: MessagePort, events: LinkEvents) {
    super(module, events);
    wire.onmessage = (event: MessageEvent<Uint8Array>) => {
      this.#guard("refused", () => {
        this.module.receive(micros(), event.data);
        [this.connection, this.fault] = ["open", ""];
      });
      this.flush();
      this.events.moved();
    };
  }

  /** Ends the connection: the robot is stopped, and the ports are closed. */
  override close(): void {
    super.close();
    this.wire.onmessage = null;
    this.wire.postMessage(null);
    this.wire.close();
  }

  protected override send(bytes: Uint8Array<ArrayBuffer>): void {
    this.wire.postMessage(bytes, [bytes.buffer]);
  }

  protected override tick(): void {
    // The rules take a while to load, so there is no timeout before their first message.
    if (this.connection !== "connecting") this.#guard("lost", () => this.module.tick(micros()));
    this.flush();
  }

  /** After an error the connection is in state `otherwise`, until the next valid message. */
  #guard(otherwise: "lost" | "refused", act: () => void): void {
    try {
      act();
    } catch (error) {
      this.connection = otherwise;
      // The module's text is about a bridge and a network, which do not exist here.
      this.fault = otherwise === "lost" ? "The robot's rules in this page have been silent for five seconds." : faultOf(error).text;
    }
  }
}
