// The connection to a bridge: a WebSocket that reconnects by itself. A robot that was lost and
// comes back continues in its old map.

import { faultOf } from "../fault.js";
import type { WebRun } from "../protocol/module.js";
import { Link, type LinkEvents, micros } from "./link.js";

/** Wall milliseconds before the first retry, and before the following ones. */
const RETRY_MILLIS = [500, 1000, 2000, 4000];

/** The meaning of the bridge's codes for closing a connection, and whether to retry. */
const CODES: Readonly<Record<number, readonly [string, boolean]>> = {
  4001: ["The bridge did not accept the token. Open the address that its owner gave you, or that it shows by “slamlab-bridge token”.", false],
  4003: ["The bridge takes no driving commands from this page: its right is not good for that.", true],
  4008: ["The bridge heard nothing from this page for too long.", true],
  4009: ["Another client took over the robot. It was stopped.", true],
  4010: ["The bridge is of another version than this page: reload the page.", false],
  4012: ["The right of this page was taken away or changed; if it drove, the robot was stopped. The robot's owner can give another.", false],
  1001: ["The bridge was shut down.", true],
  1008: ["This page said too much at once; the bridge ended the connection.", true],
  1013: ["This page did not take what the bridge had to tell it: the network is down or slow, or this device is busy.", true],
  4011: ["As many watch this robot without the token as the bridge lets in. Who opens the address with the token gets in.", true],
};

export class BridgeLink extends Link {
  #socket: WebSocket | null = null;
  #retry: ReturnType<typeof setTimeout> | null = null;
  #tries = 0;

  constructor(module: WebRun, private readonly url: string, events: LinkEvents) {
    super(module, events);
    this.#open();
  }

  override close(): void {
    super.close();
    if (this.#retry !== null) clearTimeout(this.#retry);
    if (this.#socket) this.#socket.onclose = null;
    this.#socket?.close(1000);
    this.#socket = null;
  }

  /** Messages that cannot be sent are dropped: later they would be stale. */
  protected override send(bytes: Uint8Array<ArrayBuffer>): void {
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(bytes);
  }

  protected override tick(): void {
    if (this.#socket?.readyState === WebSocket.OPEN) this.#guard(() => this.module.tick(micros()));
  }

  #open(): void {
    this.connection = "connecting";
    this.stir();
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    socket.onmessage = (event: MessageEvent<ArrayBuffer>) => this.#guard(() => this.module.receive(micros(), new Uint8Array(event.data)));
    socket.onclose = (event) => this.#lost(event.code);
    this.#socket = socket;
  }

  /** Closes the connection if the module gives up on it. */
  #guard(act: () => void): void {
    try {
      act();
    } catch (error) {
      this.fault = faultOf(error).text;
      this.#socket?.close(1000);
      return;
    }
    this.flush();
    if (this.connection === "connecting" && this.module.is_in()) {
      [this.connection, this.fault] = ["open", ""];
      this.#tries = 0;
      this.stir();
    }
    this.events.moved();
    this.report();
  }

  #lost(code: number): void {
    this.#socket = null;
    const [words, again] = CODES[code] ?? ["The bridge cannot be reached: check that it runs and that the network is up.", true];
    this.fault ||= words;
    this.connection = again ? "lost" : "refused";
    this.module.reconnect();
    this.stir();
    this.report();
    if (!again) return;
    const wait = RETRY_MILLIS[Math.min(this.#tries, RETRY_MILLIS.length - 1)];
    this.#tries += 1;
    this.#retry = setTimeout(() => this.#open(), wait);
  }
}
