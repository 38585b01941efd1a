// How certain a robot's position is, as one length.

import type { Status } from "./protocol/frame.js";
import { ellipseOf } from "./view/layers/robot.js";

/** The longer half axis of the ellipse that contains the robot with 95 % probability, m. */
export function doubtOf({ covXx, covXy, covYy }: Pick<Status, "covXx" | "covXy" | "covYy">): number {
  return ellipseOf(covXx, covXy, covYy).major;
}

/** That length over a run. */
export class DoubtHistory {
  /** Seconds within which it has to shrink by at least half. */
  static readonly SPAN = 20;
  static readonly MOST = 400;
  /** A length below this, m, is too small to attract notice when it shrinks. */
  static readonly LEAST = 0.15;
  #samples: { time: number; doubt: number }[] = [];

  get samples(): readonly { readonly time: number; readonly doubt: number }[] {
    return this.#samples;
  }

  clear(): void {
    this.#samples = [];
  }

  /** Adds a sample. If the length just collapsed, returns what it shrank from and to. */
  add(time: number, doubt: number): { from: number; to: number } | null {
    const last = this.#samples.at(-1);
    if (last && time < last.time) this.clear();
    if (last?.time === time || !Number.isFinite(doubt)) return null;
    this.#samples.push({ time, doubt });
    // Half as many samples describe a time twice as long equally well.
    if (this.#samples.length > DoubtHistory.MOST) this.#samples = this.#samples.filter((_, i) => i % 2 === 0);
    const recent = this.#samples.filter((sample) => time - sample.time <= DoubtHistory.SPAN);
    const from = Math.max(...recent.map((sample) => sample.doubt));
    return from >= DoubtHistory.LEAST && doubt < 0.5 * from ? { from, to: doubt } : null;
  }
}
