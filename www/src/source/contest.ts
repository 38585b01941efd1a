// All planners on one query: steps them in slices, takes their times, and tells how they stand.

import type { WebContest } from "../../pkg/slamlab_web.js";
import type { Answer } from "../protocol.js";
import type { ContestAsk, ContestState } from "../protocol/contest.js";

/** Wall milliseconds of one slice, and between two reports. */
const SLICE_MILLIS = 10;
const REPORT_MILLIS = 120;

export class ContestRunner {
  readonly #post: (answer: Answer) => void;
  readonly #channel = new MessageChannel();
  #contest: WebContest | null = null;
  #ask: ContestAsk | null = null;
  #watched = 0;
  #reportAt = -Infinity;
  /** A turn waits in the channel: one is enough. */
  #isDue = false;
  #isHalted = false;

  constructor(post: (answer: Answer) => void) {
    this.#post = post;
    this.#channel.port1.onmessage = () => this.#turn();
  }

  /** Begins another contest; one that cannot be leaves nothing behind. */
  begin(ask: ContestAsk, watched: number, make: () => WebContest): void {
    this.close();
    this.#ask = ask;
    this.#watched = watched;
    this.#contest = make();
    this.#reportAt = -Infinity;
    this.#isHalted = false;
    this.#wake();
  }

  /** Whose tree is told. */
  watch(place: number): void {
    this.#watched = place;
    if (this.#contest) this.#report(this.#contest, !this.#isHalted && !this.#contest.is_over());
  }

  /** Stops where it is; what was found stays to be looked at. */
  stop(): void {
    this.#isHalted = true;
    if (this.#contest) this.#report(this.#contest, false);
  }

  close(): void {
    this.#contest?.free();
    this.#contest = null;
  }

  #wake(): void {
    if (this.#isDue) return;
    this.#isDue = true;
    this.#channel.port2.postMessage(null);
  }

  #turn(): void {
    this.#isDue = false;
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
      if (goesOn) this.#wake();
    } catch (error) {
      this.close();
      this.#post({ kind: "failed", text: error instanceof Error ? error.message : String(error) });
    }
  }

  #report(contest: WebContest, running: boolean): void {
    if (!this.#ask) return;
    this.#reportAt = performance.now();
    const planners = contest.planners();
    const places = planners.map((_, place) => place);
    const [shortest = NaN, isOptimum = 0] = contest.shortest();
    const state: ContestState = {
      ...this.#ask, running, watched: this.#watched, planners, disc: contest.disc(),
      standings: contest.standings(), reasons: contest.reasons().map(reasonOf), shortest, isOptimum: isOptimum === 1,
      paths: places.map((place) => contest.path(place)), curves: places.map((place) => contest.curve(place)), tree: contest.tree(this.#watched),
    };
    this.#post({ kind: "contest", contest: state, error: "" });
  }
}

/** The first word is the kind. */
function reasonOf(text: string): ContestState["reasons"][number] {
  const [kind = ""] = text.split(" ", 1);
  return { kind, text: text.slice(kind.length + 1) };
}
