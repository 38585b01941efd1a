// The wire to a bridge: a WebSocket that comes back by itself, with the module's bytes on it.
//
// What the bytes mean is the module's matter. A robot that was lost and found again goes on in the map there was.

import type { WebRun } from "../protocol/module.js";
import type { BridgeState, Connection } from "../protocol/devices.js";

/** Wall milliseconds between two ticks of the pilot. */
const TICK_MILLIS = 50;
/** Wall milliseconds before the first new try, and before those that follow. */
const RETRY_MILLIS = [500, 1000, 2000, 4000];
const STATE_MILLIS = 250;

/** What the bridge means by the code with which it ends a connection, and whether to try again. */
const CODES: Readonly<Record<number, readonly [string, boolean]>> = {
  4001: ["The bridge did not accept the token. Open the address that it printed at its start.", false],
  4003: ["The bridge takes no driving commands from this page: it has no token.", true],
  4008: ["The bridge heard nothing from this page for too long.", true],
  4009: ["Another client took over the robot. It was stopped.", true],
  4010: ["The bridge is of another version than this page: reload the page.", false],
  1001: ["The bridge was shut down.", true],
  1008: ["This page said too much at once; the bridge ended the connection.", true],
  1013: ["This page was too slow for the bridge.", true],
};

/** The wire to a bridge, or to devices of this very computer. */
export interface Link {
  /** Sends what the module has to say. */
  flush(): void;
  /** Reports the state at the next tick. */
  stir(): void;
  close(): void;
}

export interface LinkEvents {
  /** Something came, or time passed: the run may have changed. */
  moved(): void;
  /** What bridge and robot say of themselves, a few times a second. */
  state(state: BridgeState): void;
}

/** µs of this page's clock. */
export function micros(): number {
  return performance.now() * 1000;
}

export class BridgeLink implements Link {
  readonly #module: WebRun;
  readonly #url: string;
  readonly #events: LinkEvents;
  readonly #ticker: ReturnType<typeof setInterval>;
  #socket: WebSocket | null = null;
  #retry: ReturnType<typeof setTimeout> | null = null;
  #tries = 0;
  #connection: Connection = "connecting";
  #fault = "";
  #reportedAt = -Infinity;

  constructor(module: WebRun, url: string, events: LinkEvents) {
    this.#module = module;
    this.#url = url;
    this.#events = events;
    this.#ticker = setInterval(() => this.#tick(), TICK_MILLIS);
    this.#open();
  }

  close(): void {
    clearInterval(this.#ticker);
    if (this.#retry !== null) clearTimeout(this.#retry);
    if (this.#socket) this.#socket.onclose = null;
    this.#socket?.close(1000);
    this.#socket = null;
  }

  /** Sends what the module has to say. */
  flush(): void {
    for (;;) {
      const bytes = this.#module.outgoing();
      if (bytes.length === 0) return;
      // What is said to nobody is not kept: it would be stale.
      if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(bytes as Uint8Array<ArrayBuffer>);
    }
  }

  /** Reports the state at the next tick. */
  stir(): void {
    this.#reportedAt = -Infinity;
  }

  #open(): void {
    this.#connection = "connecting";
    this.stir();
    const socket = new WebSocket(this.#url);
    socket.binaryType = "arraybuffer";
    socket.onmessage = (event: MessageEvent<ArrayBuffer>) => this.#guard(() => this.#module.receive(micros(), new Uint8Array(event.data)));
    socket.onclose = (event) => this.#lost(event.code);
    this.#socket = socket;
  }

  #tick(): void {
    if (this.#socket?.readyState === WebSocket.OPEN) this.#guard(() => this.#module.tick(micros()));
    this.#report();
  }

  /** Ends a connection on which the module has given up. */
  #guard(act: () => void): void {
    try {
      act();
    } catch (error) {
      this.#fault = error instanceof Error ? error.message : String(error);
      this.#socket?.close(1000);
      return;
    }
    this.flush();
    if (this.#connection === "connecting" && this.#module.is_in()) {
      this.#connection = "open";
      this.#fault = "";
      this.#tries = 0;
      this.stir();
    }
    this.#events.moved();
    this.#report();
  }

  #lost(code: number): void {
    this.#socket = null;
    const [words, again] = CODES[code] ?? ["The bridge cannot be reached: check that it runs and that the network is up.", true];
    this.#fault ||= words;
    this.#connection = again ? "lost" : "refused";
    this.#module.reconnect();
    this.stir();
    this.#report();
    if (!again) return;
    const wait = RETRY_MILLIS[Math.min(this.#tries, RETRY_MILLIS.length - 1)];
    this.#tries += 1;
    this.#retry = setTimeout(() => this.#open(), wait);
  }

#report(): void {
    const now = performance.now();
    if (now - this.#reportedAt < STATE_MILLIS) return;
    this.#reportedAt = now;
    this.#events.state(bridgeState(this.#module, this.#connection, this.#fault));
  }
}

/** What bridge and robot say of themselves. */
export function bridgeState(module: WebRun, connection: Connection, fault: string): BridgeState {
  return { ...module.bridge(), connection, fault };
}
