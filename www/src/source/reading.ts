// A log on its way into the module, slice by slice.

import { WebLogReader } from "../../pkg/slamlab_web.js";
import { post } from "../answer.js";
import type { ReplaySetup, WebRun } from "../protocol/module.js";

/** Bytes of a log that are read at a time, and wall milliseconds between two reports on it. */
const CHUNK = 1 << 16;
const READING_MILLIS = 50;

export class LogReading {
  readonly name: string;
  readonly #bytes: Uint8Array;
  /** None once it is read: the run has it. */
  #reader: WebLogReader | null;
  #at = 0;
  #reportedAt = -Infinity;

  constructor(name: string, bytes: ArrayBuffer, setup: ReplaySetup) {
    this.name = name;
    this.#bytes = new Uint8Array(bytes);
    this.#reader = new WebLogReader(setup);
  }

  /** Reads for so many wall milliseconds; the run once all is read. */
  readOn(millis: number): WebRun | null {
    const reader = this.#reader;
    if (!reader) return null;
    const begun = performance.now();
    while (this.#at < this.#bytes.length && performance.now() - begun < millis) {
      reader.push(this.#bytes.subarray(this.#at, this.#at + CHUNK));
      this.#at += CHUNK;
    }
    if (this.#at >= this.#bytes.length) {
      this.#reader = null;
      const run = reader.finish();
      post({ kind: "reading", name: this.name, done: null });
      return run;
    }
    if (begun - this.#reportedAt >= READING_MILLIS) {
      this.#reportedAt = begun;
      post({ kind: "reading", name: this.name, done: this.#at / this.#bytes.length });
    }
    return null;
  }

  free(): void {
    this.#reader?.free();
  }
}
