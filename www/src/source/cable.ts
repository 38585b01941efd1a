// The wire to devices at serial ports of this very page: rules and devices run in the module, the page has the ports.
//
// The messages between the rules and the one who drives are those of a bridge, so that all that is shown and done is the same.

import type { WebLive, WebNear } from "../../pkg/slamlab_web.js";
import type { LineEvent, LineWish } from "../protocol.js";
import { type LinkEvents, type Link, bridgeState, micros } from "./link.js";

/** Wall milliseconds between two looks of the devices, and of the pilot. */
const DEVICE_MILLIS = 10;
const TICK_MILLIS = 50;
const STATE_MILLIS = 250;

export class CableLink implements Link {
  readonly #module: WebLive;
  readonly #near: WebNear;
  readonly #lines: number;
  readonly #wish: (wish: LineWish) => void;
  readonly #events: LinkEvents;
  readonly #ticker: ReturnType<typeof setInterval>;
  #tickedAt = -Infinity;
  #toldAt = -Infinity;
  #fault = "";

  constructor(module: WebLive, near: WebNear, lines: number, wish: (wish: LineWish) => void, events: LinkEvents) {
    [this.#module, this.#near, this.#lines, this.#wish, this.#events] = [module, near, lines, wish, events];
    near.begin(micros());
    for (let line = 0; line < lines; line += 1) this.#want(line, "open", { baud: near.baud_rate(line) });
    this.#ticker = setInterval(() => this.#tick(), DEVICE_MILLIS);
  }

  /** Something happened at a line. */
  take({ line, event, bytes, came, why }: LineEvent): void {
    if (event === "opened") this.#near.opened(micros(), line);
    else if (event === "bytes" && bytes) this.#near.received(micros(), came === undefined ? micros() : 1000 * (came - performance.timeOrigin), line, bytes);
    else if (event === "broken") this.#near.broken(micros(), line, why ?? "the line broke");
    this.flush();
  }

  /** Carries everything to and fro until nobody has anything to say. */
  flush(): void {
    let moved = false;
    for (let goesOn = true; goesOn;) {
      goesOn = false;
      for (let bytes = this.#module.outgoing(); bytes.length > 0; bytes = this.#module.outgoing()) {
        this.#near.hear(micros(), bytes);
        goesOn = true;
      }
      for (let line = 0; line < this.#lines; line += 1) this.#wants(line);
      for (let bytes = this.#near.outgoing(); bytes.length > 0; bytes = this.#near.outgoing()) {
        this.#guard(() => this.#module.receive(micros(), bytes));
        goesOn = moved = true;
      }
    }
    if (moved) this.#events.moved();
  }

  stir(): void {
    this.#toldAt = -Infinity;
  }

  /** Stops the robot; the page closes the ports. */
  close(): void {
    clearInterval(this.#ticker);
    this.#near.close(micros());
    for (let line = 0; line < this.#lines; line += 1) {
      this.#wants(line);
      this.#want(line, "close", {});
    }
    this.#near.free();
  }

  #tick(): void {
    const now = performance.now();
    this.#near.tick(micros());
    if (now - this.#tickedAt >= TICK_MILLIS) {
      this.#tickedAt = now;
      this.#guard(() => this.#module.tick(micros()));
    }
    this.flush();
    if (now - this.#toldAt >= STATE_MILLIS) {
      this.#toldAt = now;
      this.#events.state(bridgeState(this.#module, this.#fault === "" ? "open" : "refused", this.#fault));
    }
  }

  #wants(line: number): void {
    for (let want = this.#near.next_want(line); want; want = this.#near.next_want(line)) {
      const { what, bytes, on } = want;
      want.free();
      this.#want(line, what as LineWish["want"], { bytes: bytes as Uint8Array<ArrayBuffer>, on });
    }
  }

  #want(line: number, want: LineWish["want"], { baud = 0, bytes = new Uint8Array(0), on = false }: Partial<LineWish>): void {
    this.#wish({ line, want, baud, bytes, on });
  }

  #guard(act: () => void): void {
    try {
      act();
    } catch (error) {
      this.#fault = error instanceof Error ? error.message : String(error);
    }
  }
}
