// Converts a ROS recording to one that a run reads, slice by slice, with the module of file
// formats.

import type { WebRosReader } from "../../pkg/slamlab_files.js";
import { post } from "../answer.js";
import type { ImportedLog } from "../protocol/module.js";
import type { Topics } from "../protocol.js";
import { Chunks } from "./chunks.js";
import type { FileModule } from "./files.js";

export class RosImport {
  readonly #chunks: Chunks;
  #reader: WebRosReader | null;

  constructor(module: FileModule, readonly name: string, bytes: ArrayBuffer, readonly topics: Topics | null) {
    this.#chunks = new Chunks(name, bytes);
    this.#reader = new module.WebRosReader();
  }

  /** Reads for so many wall milliseconds. Null while there is more; then the recording of the
      topics, or "asked": the page has to choose the topics first. */
  readOn(millis: number): ImportedLog | "asked" | null {
    const reader = this.#reader;
    if (!reader || !this.#chunks.readOn(millis, (bytes) => reader.push(bytes))) return null;
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
