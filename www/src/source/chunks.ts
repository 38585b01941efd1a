// Feeds the bytes of a file to a reader, slice by slice, and reports the progress.

import { post } from "../answer.js";

/** Bytes read at a time, and wall milliseconds between two reports. */
const CHUNK = 1 << 16;
const REPORT_MILLIS = 50;

export class Chunks {
  readonly #bytes: Uint8Array;
  #at = 0;
  #reportedAt = -Infinity;

  constructor(private readonly name: string, bytes: ArrayBuffer) {
    this.#bytes = new Uint8Array(bytes);
  }

  /** Reads for so many wall milliseconds. Returns whether everything is read. */
  readOn(millis: number, push: (bytes: Uint8Array) => void): boolean {
    const begun = performance.now();
    for (; this.#at < this.#bytes.length && performance.now() - begun < millis; this.#at += CHUNK) {
      push(this.#bytes.subarray(this.#at, this.#at + CHUNK));
    }
    if (begun - this.#reportedAt >= REPORT_MILLIS) {
      this.#reportedAt = begun;
      post({ kind: "reading", name: this.name, done: Math.min(1, this.#at / Math.max(1, this.#bytes.length)) });
    }
    return this.#at >= this.#bytes.length;
  }
}
