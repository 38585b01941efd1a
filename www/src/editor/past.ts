// The undo and redo history of a drawing.

import type { Drawing } from "./drawing.js";

/** Steps kept; the oldest are dropped first. */
const MOST_STEPS = 500;

export class Past {
  #steps: Drawing[];
  #at = 0;
  /** The gesture of the newest step: dragging a corner is one step, not one for each move. */
  #gesture: string | null = null;

  constructor(first: Drawing) {
    this.#steps = [first];
  }

  get drawing(): Drawing {
    return this.#steps[this.#at] as Drawing;
  }

  get canUndo(): boolean {
    return this.#at > 0;
  }

  get canRedo(): boolean {
    return this.#at < this.#steps.length - 1;
  }

  /** Records a new drawing. Consecutive steps of one `gesture` are undone together. */
  put(drawing: Drawing, gesture: string | null = null): void {
    if (drawing === this.drawing) return;
    const joins = gesture !== null && gesture === this.#gesture && this.#at > 0;
    const before = this.#steps.slice(0, joins ? this.#at : this.#at + 1);
    this.#steps = [...before, drawing].slice(-MOST_STEPS);
    this.#at = this.#steps.length - 1;
    this.#gesture = gesture;
  }

  /** The next change is a gesture of its own. */
  pause(): void {
    this.#gesture = null;
  }

  undo(): void {
    if (this.canUndo) this.#at -= 1;
    this.#gesture = null;
  }

  redo(): void {
    if (this.canRedo) this.#at += 1;
    this.#gesture = null;
  }
}
