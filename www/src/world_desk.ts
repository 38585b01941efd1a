// What the client hands to the world editor, whose code is a bundle of its own.

import type { WorldFault } from "./protocol/module.js";

export interface WorldDesk {
  /** A world to draw on: the text of its file, and what of the file it came from is not in it. */
  open(name: string, text: string, skipped: readonly string[]): void;
  /** What is wrong with the drawing of this number; null: nothing. */
  judge(number: number, fault: WorldFault | null): void;
}
