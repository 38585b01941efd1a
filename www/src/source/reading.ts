// A log on its way into the module, slice by slice.

import { type WebReplay, WebLogReader } from "../../pkg/slamlab_web.js";
import { post } from "../answer.js";
import type { Command } from "../protocol.js";
import type { MethodName, SettingValues } from "../protocol/setup.js";
import { knownOf } from "./building.js";
import { listOf } from "./convert.js";

/** Bytes of a log that are read at a time, and wall milliseconds between two reports on it. */
const CHUNK = 1 << 16;
const READING_MILLIS = 50;

export class LogReading {
  readonly name: string;
  readonly method: MethodName;
  readonly #bytes: Uint8Array;
  /** None once it is read: the replay has it. */
  #reader: WebLogReader | null;
  #at = 0;
  #toldAt = -Infinity;

  /** With what is known better of its robot than the log says. */
  constructor({ name, method, bytes, settings, known }: Extract<Command, { kind: "replay" }>, told: { settings: SettingValues; twin: boolean }) {
    this.name = name;
    this.method = method;
    this.#bytes = new Uint8Array(bytes);
    const reader = new WebLogReader(method, ...listOf({ ...settings, ...told.settings }));
    if (told.twin) reader.with_twin();
    if (known) reader.find_in(knownOf(known));
    this.#reader = reader;
  }

  /** Reads for so many wall milliseconds; the replay once all is read. */
  readOn(millis: number): WebReplay | null {
    const reader = this.#reader;
    if (!reader) return null;
    const begun = performance.now();
    while (this.#at < this.#bytes.length && performance.now() - begun < millis) {
      reader.push(this.#bytes.subarray(this.#at, this.#at + CHUNK));
      this.#at += CHUNK;
    }
    if (this.#at >= this.#bytes.length) {
      this.#reader = null;
      const replay = reader.finish();
      post({ kind: "reading", name: this.name, done: null });
      return replay;
    }
    if (begun - this.#toldAt >= READING_MILLIS) {
      this.#toldAt = begun;
      post({ kind: "reading", name: this.name, done: this.#at / this.#bytes.length });
    }
    return null;
  }

  free(): void {
    this.#reader?.free();
  }
}
