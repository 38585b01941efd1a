// The client's interface to the world editor, whose code is a bundle of its own.

import type { WorldFault } from "./protocol/module.js";

export interface WorldDesk {
  /** Opens a world for editing: the text of its file, and what was left out of the original. */
  open(name: string, text: string, skipped: readonly string[]): void;
  /** Opens a built-in world that was asked for, unless something else was opened since. */
  openAsked(world: string, text: string): void;
  /** The error in the drawing of this number; null: none. */
  judge(number: number, fault: WorldFault | null): void;
}
