// Reads a log into the module, slice by slice.

import { WebLogReader } from "../../pkg/slamlab_web.js";
import { post } from "../answer.js";
import type { ReplaySetup, WebRun } from "../protocol/module.js";
import { Chunks } from "./chunks.js";

export class LogReading {
  readonly #chunks: Chunks;
  /** Null once everything is read: then the run owns it. */
  #reader: WebLogReader | null;

  constructor(readonly name: string, bytes: ArrayBuffer, setup: ReplaySetup) {
    this.#chunks = new Chunks(name, bytes);
    this.#reader = new WebLogReader(setup);
  }

  /** Reads for so many wall milliseconds. Returns the run once everything is read. */
  readOn(millis: number): WebRun | null {
    const reader = this.#reader;
    if (!reader || !this.#chunks.readOn(millis, (bytes) => reader.push(bytes))) return null;
    this.#reader = null;
    const run = reader.finish();
    post({ kind: "reading", name: this.name, done: null });
    return run;
  }

  free(): void {
    this.#reader?.free();
  }
}
