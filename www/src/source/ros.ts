// A recording of ROS on its way to a recording that a run reads: by the module of file formats,
// slice by slice.

import type { WebRosReader } from "../../pkg/slamlab_files.js";
import { post } from "../answer.js";
import type { ImportedLog } from "../protocol/module.js";
import type { Topics } from "../protocol.js";
import type { FileModule } from "./files.js";

/** Bytes that are read at a time, and wall milliseconds between two reports on it. */
const CHUNK = 1 << 18;
const READING_MILLIS = 50;

export class RosImport {
  readonly #bytes: Uint8Array;
  #reader: WebRosReader | null;
  #at = 0;
  #reportedAt = -Infinity;

  constructor(module: FileModule, readonly name: string, bytes: ArrayBuffer, readonly topics: Topics | null) {
    this.#bytes = new Uint8Array(bytes);
    this.#reader = new module.WebRosReader();
  }

  /** Reads for so many wall milliseconds. Null while there is more; then the recording of the
      topics, or "asked": the page is to say first which of them are meant. */
  readOn(millis: number): ImportedLog | "asked" | null {
    const reader = this.#reader;
    if (!reader) return null;
    const begun = performance.now();
    for (; this.#at < this.#bytes.length && performance.now() - begun < millis; this.#at += CHUNK) {
      reader.push(this.#bytes.subarray(this.#at, this.#at + CHUNK));
    }
    if (begun - this.#reportedAt >= READING_MILLIS) {
      this.#reportedAt = begun;
      post({ kind: "reading", name: this.name, done: Math.min(1, this.#at / this.#bytes.length) });
    }
    if (this.#at < this.#bytes.length) return null;
    const offered = reader.finish();
    if (this.topics === null && offered.mustAsk) {
      post({ kind: "topics", name: this.name, offered });
      return "asked";
    }
    return reader.import(this.topics?.scans ?? undefined, this.topics?.odometry ?? undefined);
  }

  free(): void {
    this.#reader?.free();
    this.#reader = null;
  }
}
