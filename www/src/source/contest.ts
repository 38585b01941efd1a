// Runs all planners on one query: steps them in slices, measures their times, and reports their
// state.

import { fail, post } from "../answer.js";
import { faultOf } from "../fault.js";
import type { WebContest } from "../protocol/module.js";
import { Turns } from "../turns.js";

/** Wall milliseconds of one slice, and between two reports. */
const SLICE_MILLIS = 10;
const REPORT_MILLIS = 120;

export class ContestRunner {
  readonly #turns = new Turns(() => this.#turn());
  #contest: WebContest | null = null;
  #watched = 0;
  #reportAt = -Infinity;
  #isHalted = false;

  /** Begins another contest; if that fails, there is none. */
  begin(watched: number, make: () => WebContest): void {
    this.close();
    this.#watched = watched;
    try {
      this.#contest = make();
    } catch (error) {
      post({ kind: "contest", contest: null, running: false, error: faultOf(error).text });
      return;
    }
    this.#reportAt = -Infinity;
    this.#isHalted = false;
    this.#turns.wake();
  }

  /** Chooses the planner whose tree is sent. */
  watch(place: number): void {
    this.#watched = place;
    if (this.#contest) this.#report(this.#contest, !this.#isHalted && !this.#contest.is_over());
  }

  /** Stops where it is; the results so far stay visible. */
  stop(): void {
    this.#isHalted = true;
    if (this.#contest) this.#report(this.#contest, false);
  }

  close(): void {
    this.#contest?.free();
    this.#contest = null;
  }

  #turn(): void {
    const contest = this.#contest;
    if (!contest || this.#isHalted) return;
    try {
      const begin = performance.now();
      let goesOn = true;
      for (let now = begin; goesOn && now - begin < SLICE_MILLIS;) {
        goesOn = contest.step();
        const after = performance.now();
        if (goesOn) contest.took((after - now) / 1000);
        now = performance.now();
      }
      if (!goesOn || begin - this.#reportAt >= REPORT_MILLIS) this.#report(contest, goesOn);
      if (goesOn) this.#turns.wake();
    } catch (error) {
      this.close();
      fail(error);
    }
  }

  #report(contest: WebContest, running: boolean): void {
    this.#reportAt = performance.now();
    post({ kind: "contest", contest: contest.state(this.#watched), running, error: "" });
  }
}
