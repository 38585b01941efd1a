// Serial ports of this computer, through Web Serial: the person chooses them, and bytes pass
// through here. The local bridge, in a worker of its own (local_bridge.ts), interprets them and
// decides when a line is reopened.

import { faultOf } from "./fault.js";
import type { LineWish, LocalBridgeAnswer, LocalBridgeCommand } from "./protocol/devices.js";
import type { DeviceKind } from "./protocol/module.js";
import { t } from "./words.js";

/** Milliseconds before retries of a line; the last applies to all further ones. */
const RETRY_MILLIS = [250, 500, 1000, 2000];
/** Wall milliseconds to wait for a port, or for the worker with the rules, on leaving. */
const LEAVE_MILLIS = 1000;

/** The part of Web Serial used here; TypeScript's library has no types for it. */
interface Port {
  readonly readable: ReadableStream<Uint8Array> | null;
  readonly writable: WritableStream<Uint8Array> | null;
  open(options: { baudRate: number; bufferSize?: number }): Promise<void>;
  close(): Promise<void>;
  setSignals(signals: { dataTerminalReady: boolean }): Promise<void>;
  getInfo(): { usbVendorId?: number; usbProductId?: number };
}

interface Serial extends EventTarget {
  requestPort(options: { filters?: DeviceKind["adapters"] }): Promise<Port>;
  getPorts(): Promise<Port[]>;
}

/** Web Serial, if the browser has it: Chrome, Edge and Opera on a computer, from this computer's
    own address or `https`. */
export function webSerial(): Serial | null {
  return (navigator as Navigator & { serial?: Serial }).serial ?? null;
}

class Line {
  baud = 0;
  reader: ReadableStreamDefaultReader<Uint8Array> | null = null;
  writer: WritableStreamDefaultWriter<Uint8Array> | null = null;
  retry: ReturnType<typeof setTimeout> | null = null;
  tries = 0;
  /** From a failure until it is opened again. */
  isBroken = false;
  /** The run that uses it has ended. */
  isLeft = false;
  /** Resolves when all written bytes are sent and the port is closed. */
  readonly closed: Promise<void>;
  isClosed: () => void = () => {};

  /** `wasOpen`: its port was open once, in this run or an earlier one, so it is the right one. */
  constructor(readonly kind: string, public port: Port, public wasOpen = false) {
    this.closed = new Promise((done) => (this.isClosed = done));
  }

  /** The same line for another run. */
  again(): Line {
    return new Line(this.kind, this.port, this.wasOpen);
  }

  /** Whether this port may be the same adapter plugged in again: the browser then reports a new
      port. */
  isLike(port: Port): boolean {
    const [ours, theirs] = [this.port.getInfo(), port.getInfo()];
    return ours.usbVendorId !== undefined && ours.usbVendorId === theirs.usbVendorId && ours.usbProductId === theirs.usbProductId;
  }
}

export class SerialPorts {
  #lines: Line[] = [];
  #rules: Worker | null = null;
  /** Started in advance, and kept from run to run. */
  #spare: Worker | null = null;
  #leaving: Promise<void> | null = null;

  /** `failed`: the rules have failed for good, and the lines were closed. */
  constructor(private readonly failed: (text: string) => void) {
    webSerial()?.addEventListener("connect", (event) => void this.#connected(event.target as unknown as Port));
  }

  /** Loads the rules before the first run if somebody has used a device before, so that the run can
      begin at once. */
  async prepare(): Promise<void> {
    const ports = await webSerial()?.getPorts().catch(() => []);
    if (!ports?.length || this.#rules || this.#spare) return;
    this.#keep(rulesWorker());
  }

  /** Loads the rules ahead of the next run. If that fails, plugging in a device tries again and
      shows the reason. */
  #keep(spare: Worker): void {
    const drop = () => {
      if (this.#spare !== spare) return;
      this.#spare = null;
      spare.terminate();
    };
    spare.onerror = drop;
    spare.onmessage = (event: MessageEvent<LocalBridgeAnswer>) => {
      if (event.data.kind === "failed") drop();
    };
    this.#spare = spare;
  }

  /** The devices at the ports, in the order of their numbers. */
  get kinds(): string[] {
    return this.#lines.map((line) => line.kind);
  }

  /** Adds a device. Asks the person for its port, among those of its usual adapters or among
      all. */
  async choose({ name: kind, adapters }: DeviceKind, ofAll: boolean): Promise<void> {
    const port = await webSerial()?.requestPort(ofAll ? {} : { filters: adapters });
    if (!port) throw new Error("This browser has no Web Serial.");
    await this.leave();
    const others = this.#lines.filter((line) => line.kind !== kind && line.port !== port);
    this.#lines = [...others.map((line) => line.again()), new Line(kind, port)];
  }

  /** Prepares the same lines for a run that restarts. */
  async again(): Promise<void> {
    await this.leave();
    this.#lines = this.#lines.map((line) => line.again());
  }

  /** Drops all devices. */
  async forget(): Promise<void> {
    await this.leave();
    this.#lines = [];
  }

  /** Starts devices and rules, which open the lines. Returns the wire for the worker that maps and
      drives. */
  begin(): MessagePort {
    this.#endRules();
    const { port1: driver, port2: wire } = new MessageChannel();
    const rules = this.#spare ?? rulesWorker();
    this.#spare = null;
    rules.onmessage = (event: MessageEvent<LocalBridgeAnswer>) => {
      if (this.#rules !== rules) return;
      if (event.data.kind === "line") this.#wish(event.data);
      else this.#lose(rules, event.data.text);
    };
    rules.onerror = (event) => this.#lose(rules, event.message || "the worker with its rules could not be started");
    this.#rules = rules;
    this.#send({ kind: "begin", devices: this.kinds, driver }, [driver]);
    return wire;
  }

  /** Stops the robot at once; with `cutOff` its motors stay off. */
  stop(cutOff: boolean): void {
    this.#send({ kind: "stop", cutOff });
  }

  /** Ends the run that uses the lines: the robot is stopped first, then they are closed. A second
      call waits for the same end. */
  leave(): Promise<void> {
    this.#leaving ??= this.#leave().finally(() => (this.#leaving = null));
    return this.#leaving;
  }

  async #leave(): Promise<void> {
    this.#send({ kind: "end" });
    const used = this.#lines.filter((line) => line.baud > 0);
    await within(LEAVE_MILLIS, Promise.all(used.map((line) => line.closed)));
    const hasAnswered = used.every((line) => line.isLeft);
    // Rules that no longer answer have not closed the line.
    for (const line of used) if (!line.isLeft) void this.#close(line);
    await Promise.all(used.map((line) => line.closed));
    if (hasAnswered && this.#rules) {
      this.#keep(this.#rules);
      this.#rules = null;
    }
    this.#endRules();
  }

  #endRules(): void {
    this.#rules?.terminate();
    this.#rules = null;
  }

  #send(command: LocalBridgeCommand, transfer: Transferable[] = []): void {
    this.#rules?.postMessage(command, transfer);
  }

  /** Without its rules the robot gets no more messages, so it stops by itself. */
  #lose(rules: Worker, text: string): void {
    if (this.#rules !== rules) return;
    this.#endRules();
    for (const line of this.#lines) void this.#close(line);
    this.failed(t`The robot at the cable was left: ${text}`);
  }

  /** An adapter was plugged in: if it belongs to a broken line, that line is opened at once. */
  async #connected(port: Port): Promise<void> {
    const there = (await webSerial()?.getPorts()) ?? [];
    const down = this.#lines.filter((line) => line.baud > 0 && line.reader === null && !line.isLeft);
    // A port that is only busy, or was never open, is not looked for at another adapter.
    const alike = down.filter((line) => line.wasOpen && !there.includes(line.port) && line.isLike(port));
    // Two identical adapters cannot be told apart: the person has to choose.
    const line = down.find((line) => line.port === port) ?? (alike.length === 1 ? alike[0] : undefined);
    if (!line) return;
    [line.port, line.tries] = [port, 0];
    if (line.retry === null) return;
    clearTimeout(line.retry);
    void this.#open(this.#lines.indexOf(line), line);
  }

  /** Does what a device wants done with its line. */
  #wish({ line: number, want, baud, bytes, on }: LineWish): void {
    const line = this.#lines[number];
    if (!line || line.isLeft) return;
    if (want === "open") {
      line.baud = baud;
      void this.#open(number, line);
    } else if (want === "write") {
      line.writer?.write(bytes).catch(() => {
        // The reader reports a broken line.
      });
    } else if (want === "dtr") {
      line.port.setSignals({ dataTerminalReady: on }).catch(() => {
        // A plain line without DTR is not affected.
      });
    } else if (want === "close") {
      void this.#close(line);
    } else if (want === "reopen") {
      // The error is shown until it is open again.
      if (line.reader !== null) void this.#broke(number, line, null);
    } else {
      line.tries = 0;
    }
  }

  async #close(line: Line): Promise<void> {
    line.isLeft = true;
    await shut(line);
    line.isClosed();
  }

  async #open(number: number, line: Line): Promise<void> {
    [line.retry, line.isBroken] = [null, false];
    try {
      await line.port.open({ baudRate: line.baud, bufferSize: 4096 });
      if (line.isLeft) return await shut(line);
      const { readable, writable } = line.port;
      if (!readable || !writable) throw new Error("the port cannot be read and written");
      line.reader = readable.getReader();
      line.writer = writable.getWriter();
      line.wasOpen = true;
      this.#send({ kind: "line", line: number, event: "opened" });
      for (;;) {
        const { value, done } = await line.reader.read();
        if (done) throw new Error("the port sends nothing any more: check the cable");
        const bytes = value.slice();
        this.#send({ kind: "line", line: number, event: "bytes", bytes, came: performance.timeOrigin + performance.now() }, [bytes.buffer]);
      }
    } catch (error) {
      await this.#broke(number, line, faultOf(error).text);
    }
  }

  /** Reports that a line broke, if there is a reason to give, and tries it again after a while. */
  async #broke(number: number, line: Line, why: string | null): Promise<void> {
    if (line.isLeft || line.isBroken) return;
    line.isBroken = true;
    const wait = RETRY_MILLIS[Math.min(line.tries, RETRY_MILLIS.length - 1)];
    line.tries += 1;
    if (why !== null) this.#send({ kind: "line", line: number, event: "broken", why });
    const { reader, writer, port } = line;
    [line.reader, line.writer] = [null, null];
    await shut({ reader, writer, port, retry: null }, false);
    if (!line.isLeft) line.retry = setTimeout(() => void this.#open(number, line), wait);
  }
}

function rulesWorker(): Worker {
  return new Worker(new URL("local_bridge.js", import.meta.url), { type: "module", name: "slamlab-local-bridge" });
}

/** Whether it ends in time, successfully or not. */
async function within(millis: number, act: Promise<unknown>): Promise<boolean> {
  let timer: ReturnType<typeof setTimeout> | undefined;
  const late = new Promise<boolean>((done) => (timer = setTimeout(() => done(false), millis)));
  const ended = await Promise.race([act.then(() => true, () => true), late]);
  clearTimeout(timer);
  return ended;
}

/** Ends reading and writing, and closes the port, even if it is broken; steps that hang are
    abandoned. Bytes not sent yet are sent first only if `sends`: after a fault a command to move
    would come late. */
async function shut({ port, reader, writer, retry }: Pick<Line, "port" | "reader" | "writer" | "retry">, sends = true): Promise<void> {
  if (retry !== null) clearTimeout(retry);
  // A device that accepts no bytes keeps a write waiting for ever.
  const isSent = writer && sends && (await within(LEAVE_MILLIS, writer.close()));
  if (writer && !isSent) await within(LEAVE_MILLIS, writer.abort());
  writer?.releaseLock();
  if (reader) await within(LEAVE_MILLIS, reader.cancel());
  reader?.releaseLock();
  await within(LEAVE_MILLIS, port.close());
}
