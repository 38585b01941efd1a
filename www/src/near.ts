// Robot and sensors at serial ports of this very page: devices and rules run here, in a worker of their own, so that nothing that whoever
// maps has to do (a plan, a fit) keeps them waiting. The page has the ports, and its Stop comes straight to here.
//
// With the one who maps and drives they exchange the messages of a bridge, over a port of its own; `null` is its farewell.

import init, { WebNear } from "../pkg/slamlab_web.js";
import type { LineEvent, LineWish, NearAnswer, NearCommand } from "./protocol/devices.js";
import { micros } from "./source/link.js";

/** Wall milliseconds between two looks of the devices. */
const DEVICE_MILLIS = 10;

const post = (answer: NearAnswer, transfer: Transferable[] = []): void => {
  (self as unknown as { postMessage(message: NearAnswer, transfer: Transferable[]): void }).postMessage(answer, transfer);
};

class Lines {
  readonly #near: WebNear;
  readonly #count: number;
  readonly #driver: MessagePort;
  readonly #ticker: ReturnType<typeof setInterval>;

  constructor({ devices, driver }: Extract<NearCommand, { kind: "begin" }>) {
    this.#near = new WebNear([...devices]);
    this.#count = devices.length;
    this.#driver = driver;
    driver.onmessage = (event: MessageEvent<Uint8Array | null>) => heard(event.data);
    this.#near.begin(micros());
    for (let line = 0; line < this.#count; line += 1) wish(line, "open", { baud: this.#near.baud_rate(line) });
    this.#ticker = setInterval(() => guard(() => this.#tick()), DEVICE_MILLIS);
    this.flush();
  }

  /** What the one who drives says. */
  hear(bytes: Uint8Array): void {
    this.#near.hear(micros(), bytes);
    this.flush();
  }

  /** Something happened at a line. */
  take({ line, event, bytes, came, why }: LineEvent): void {
    if (event === "opened") this.#near.opened(micros(), line);
    else if (event === "bytes" && bytes) this.#near.received(micros(), came === undefined ? micros() : 1000 * (came - performance.timeOrigin), line, bytes);
    else if (event === "broken") this.#near.broken(micros(), line, why ?? "the line broke");
    this.flush();
  }

  stop(cutOff: boolean): void {
    this.#near.stop(micros(), cutOff);
    this.flush();
  }

  /** Stops the robot, and has the lines closed: also where the rules themselves have failed and cannot say anything more. */
  close(): void {
    clearInterval(this.#ticker);
    try {
      this.#near.close(micros());
      this.flush();
      this.#near.free();
    } finally {
      for (let line = 0; line < this.#count; line += 1) wish(line, "close", {});
      this.#driver.close();
    }
  }

  #tick(): void {
    this.#near.tick(micros());
    this.flush();
  }

  /** What devices want of their lines, and what is said to the one who drives. */
  flush(): void {
    for (let line = 0; line < this.#count; line += 1) {
      for (let want = this.#near.next_want(line); want; want = this.#near.next_want(line)) {
        const { what, bytes, on } = want;
        want.free();
        wish(line, what as LineWish["want"], { bytes: bytes as Uint8Array<ArrayBuffer>, on });
      }
    }
    for (let bytes = this.#near.outgoing(); bytes.length > 0; bytes = this.#near.outgoing()) this.#driver.postMessage(bytes, [bytes.buffer]);
  }
}

let lines: Lines | null = null;

function wish(line: number, want: LineWish["want"], { baud = 0, bytes = new Uint8Array(0), on = false }: Partial<LineWish>): void {
  post({ kind: "line", line, want, baud, bytes, on });
}

function heard(bytes: Uint8Array | null): void {
  guard(() => {
    if (bytes === null) end();
    else lines?.hear(bytes);
  });
}

function end(): void {
  const ended = lines;
  lines = null;
  ended?.close();
}

function handle(command: NearCommand): void {
  switch (command.kind) {
    case "begin":
      lines = new Lines(command);
      break;
    case "line":
      lines?.take(command);
      break;
    case "stop":
      lines?.stop(command.cutOff);
      break;
    case "end":
      end();
      break;
  }
}

function guard(act: () => void): void {
  try {
    act();
  } catch (error) {
    console.error(error);
    // Nobody knows what comes of it: the robot is left standing.
    try {
      end();
    } catch (also) {
      console.error(also);
    }
    post({ kind: "failed", text: error instanceof Error ? error.message : String(error) });
  }
}

const isLoaded = init({ module_or_path: new URL("slamlab_web_bg.wasm", self.location.href) }).then(() => true, (error: unknown) => {
  post({ kind: "failed", text: `The rules of the robot could not be loaded: ${String(error)}. Reload the page.` });
  return false;
});

self.onmessage = async (event: MessageEvent<NearCommand>) => {
  if (await isLoaded) guard(() => handle(event.data));
};
