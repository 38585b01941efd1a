// The local bridge: devices at serial ports of this page, and the rules of a bridge, in a worker of
// their own, so that no planning or fitting delays them. The page owns the ports, and its Stop
// button comes straight here.
//
// The client, which maps and drives, exchanges the messages of a bridge with it over a message
// port; `null` ends the connection.

import init, { WebLocalBridge } from "../pkg/slamlab_cable.js";
import { faultOf } from "./fault.js";
import type { LineEvent, LineWish, LocalBridgeAnswer, LocalBridgeCommand } from "./protocol/devices.js";
import { handle, type Handlers } from "./protocol.js";
import { micros } from "./source/link.js";

/** Wall milliseconds between two polls of the devices. */
const DEVICE_MILLIS = 10;

const post = (answer: LocalBridgeAnswer, transfer: Transferable[] = []): void => {
  (self as unknown as { postMessage(message: LocalBridgeAnswer, transfer: Transferable[]): void }).postMessage(answer, transfer);
};

class Lines {
  readonly #bridge: WebLocalBridge;
  readonly #count: number;
  readonly #driver: MessagePort;
  readonly #ticker: ReturnType<typeof setInterval>;

  constructor({ devices, driver }: Extract<LocalBridgeCommand, { kind: "begin" }>) {
    this.#bridge = new WebLocalBridge([...devices]);
    this.#count = devices.length;
    this.#driver = driver;
    driver.onmessage = (event: MessageEvent<Uint8Array | null>) => received(event.data);
    this.#bridge.begin(micros());
    for (let line = 0; line < this.#count; line += 1) wish(line, "open", { baud: this.#bridge.baud_rate(line) });
    this.#ticker = setInterval(() => guard(() => this.#tick()), DEVICE_MILLIS);
    this.flush();
  }

  /** A message of the client. */
  message(bytes: Uint8Array): void {
    this.#bridge.message(micros(), bytes);
    this.flush();
  }

  /** Handles an event at a line. */
  take({ line, event, bytes, came, why }: LineEvent): void {
    if (event === "opened") this.#bridge.opened(micros(), line);
    else if (event === "bytes" && bytes) this.#bridge.received(micros(), came === undefined ? micros() : 1000 * (came - performance.timeOrigin), line, bytes);
    else if (event === "broken") this.#bridge.broken(micros(), line, why ?? "the line broke");
    this.flush();
  }

  stop(cutOff: boolean): void {
    this.#bridge.stop(micros(), cutOff);
    this.flush();
  }

  /** Stops the robot, and has the lines closed: also if the rules themselves have failed and cannot
      act any more. */
  close(): void {
    clearInterval(this.#ticker);
    try {
      this.#bridge.close(micros());
      this.flush();
      this.#bridge.free();
    } finally {
      for (let line = 0; line < this.#count; line += 1) wish(line, "close", {});
      this.#driver.close();
    }
  }

  #tick(): void {
    this.#bridge.tick(micros());
    this.flush();
  }

  /** Passes on what devices want of their lines, and messages for the client. */
  flush(): void {
    for (let line = 0; line < this.#count; line += 1) {
      for (let want = this.#bridge.next_want(line); want; want = this.#bridge.next_want(line)) {
        const { what, bytes, on } = want;
        want.free();
        wish(line, what as LineWish["want"], { bytes: bytes as Uint8Array<ArrayBuffer>, on });
      }
    }
    for (const bytes of this.#bridge.outgoing()) this.#driver.postMessage(bytes, [bytes.buffer]);
  }
}

let lines: Lines | null = null;

function wish(line: number, want: LineWish["want"], { baud = 0, bytes = new Uint8Array(0), on = false }: Partial<LineWish>): void {
  post({ kind: "line", line, want, baud, bytes, on });
}

function received(bytes: Uint8Array | null): void {
  guard(() => {
    if (bytes === null) end();
    else lines?.message(bytes);
  });
}

function end(): void {
  const ended = lines;
  lines = null;
  ended?.close();
}

const handlers: Handlers<LocalBridgeCommand> = {
  begin: (command) => (lines = new Lines(command)),
  line: (event) => lines?.take(event),
  stop: ({ cutOff }) => lines?.stop(cutOff),
  end,
};

function guard(act: () => void): void {
  try {
    act();
  } catch (error) {
    console.error(error);
    // The rules may be in an unknown state: leave the robot standing.
    try {
      end();
    } catch (also) {
      console.error(also);
    }
    post({ kind: "failed", text: faultOf(error).text });
  }
}

const isLoaded = init({ module_or_path: new URL("slamlab_cable_bg.wasm", self.location.href) }).then(() => true, (error: unknown) => {
  post({ kind: "failed", text: `The rules of the robot could not be loaded: ${String(error)}. Reload the page.` });
  return false;
});

self.onmessage = async (event: MessageEvent<LocalBridgeCommand>) => {
  if (await isLoaded) guard(() => handle(handlers, event.data));
};
