// Plays a run: paces it (run seconds per wall second), works in slices short enough for every
// message to be handled within about 20 ms, and sends a frame only when the page has drawn the one
// before.

import { fail, post } from "../answer.js";
import type { Answer } from "../protocol.js";
import { transferables } from "../protocol/frame.js";
import type { MapVerdictName, Quality, WebJudgement } from "../protocol/module.js";
import { Extras } from "./extras.js";
import { Pace } from "./pace.js";
import type { Run } from "./run.js";

/** Wall milliseconds until the next slice when there is nothing to do yet. */
const IDLE_MILLIS = 6;
/** Wall milliseconds of one slice. */
export const SLICE_MILLIS = 12;
/** Interval for reporting the hash while a run plays, wall milliseconds. */
const HASH_MILLIS = 500;
/** While a recording is mapped, its map is judged again when it has grown by this factor. */
const JUDGED_AGAIN = 1.5;
/** Share of the recording from which on a judgement is worthwhile. */
const JUDGED_FROM = 0.1;

/** A good map needs no message. */
const TOLD: Readonly<Record<MapVerdictName, string>> = {
  good: "",
  doubtful: "Parts of the map may lie elsewhere: Status says which",
  torn: "The map is torn: Status says where and why",
};

const told = ({ verdict, unjudgeable, tears }: Quality): string =>
  unjudgeable && tears.length === 0 ? "Nothing can be said of the map: Status says why" : TOLD[verdict];

type Started = Extract<Answer, { kind: "started" }>;

export class Player {
  run: Run | null = null;
  /** Called before another run is shown. */
  onBegin: () => void = () => {};
  /** Work that comes before the run, slice by slice, such as reading a log. Returns whether there
      is more. */
  before: (() => boolean) | null = null;
  readonly extras = new Extras();
  readonly #pace = new Pace();
  /** Number of the run that is shown. */
  number = 0;
  #seq = 0;
  #playing = false;
  /** The page has drawn the last frame and can take another. */
  #pageReady = true;
  /** Something changed that no frame has shown yet. */
  #stale = false;
  #hashAt = -Infinity;
  #begunAt = 0;
  /** Share of the recording that was mapped when its map was last judged. */
  #judgedAt = 0;
  #scheduled = false;
  /** What the run began with, as the page knows it. */
  #setup: Started["setup"] = null;
  /** Runs as fast as possible until this holds; then it waits. */
  #until: ((run: Run) => boolean) | null = null;
  /** Where it waits, s: runs beside it have come no further. */
  #heldAt = Infinity;
  readonly #immediate = new MessageChannel();

  constructor() {
    this.#immediate.port1.onmessage = () => this.#turn();
  }

  /** Shows another run from here on. */
  begin(run: Run, { setup, playing, isAgain = false }: Pick<Started, "setup" | "playing"> & { isAgain?: boolean }): void {
    this.onBegin();
    this.#until = null;
    this.#setup = setup;
    this.run?.close();
    this.run = run;
    this.extras.reset();
    this.number += 1;
    this.#seq = 0;
    this.#hashAt = -Infinity;
    this.#begunAt = performance.now();
    this.#judgedAt = 0;
    this.#playing = playing;
    const { kind: source, title, method } = run;
    post({ kind: "started", run: this.number, source, title, method, setup, playing, isAgain });
    this.#rebase();
    this.#pageReady = true;
    this.changed();
    this.schedule();
  }

  play(next: boolean): void {
    this.#until = null;
    if (next !== this.#playing) {
      this.#playing = next;
      post({ kind: "playing", playing: next });
    }
    this.#hashAt = -Infinity;
    this.#stale = true;
    this.resume();
  }

  /** Goes to where `isThere` holds and waits there; from the beginning, if that has passed. */
  seek(hasPassed: boolean, isThere: (run: Run) => boolean): void {
    const { run } = this;
    if (!run || run.kind === "bridge") return;
    if (hasPassed) this.begin(run.again(), { setup: this.#setup, playing: true, isAgain: true });
    this.play(true);
    this.#until = isThere;
  }

  /** Continues by the clock from here. */
  resume(): void {
    this.#rebase();
    this.schedule();
  }

  /** Run seconds per wall second; Infinity is as fast as possible. */
  setSpeed(factor: number): void {
    this.#pace.speed = factor;
    this.resume();
  }

  /** Waits at this moment, s. */
  holdAt(time: number): void {
    this.#heldAt = time;
    this.schedule();
  }

  /** The page has drawn the last frame. */
  drawn(): void {
    this.#pageReady = true;
    if (this.#stale) this.show();
  }

  /** Something has to be shown. */
  changed(): void {
    this.#stale = true;
    this.show();
  }

  /** Sends a frame if there is something new and the page can take one. */
  show(): void {
    const { run } = this;
    if (!run) return;
    for (const note of run.notes()) post({ kind: "event", run: this.number, ...note });
    const settings = run.module.take_followed_settings();
    if (settings) post({ kind: "followed-settings", run: this.number, settings });
    const now = performance.now();
    // While the run stands, a person's change is reported at once: nothing may come after it.
    if (now - this.#hashAt >= HASH_MILLIS || (this.#stale && !this.#playing)) {
      this.#hashAt = now;
      post({ kind: "hash", run: this.number, text: run.module.state_hash() });
      if (this.#setup?.lesson) post({ kind: "grade", run: this.number, grade: run.module.grade() ?? null });
    }
    if (!this.#pageReady || !this.#stale) return;
    this.#pageReady = false;
    this.#stale = false;
    this.#seq += 1;
    // The status counts what the change has just fetched.
    const change = run.change();
    const bare = run.status();
    const elapsed = run.kind === "replay" ? (performance.now() - this.#begunAt) / 1000 : NaN;
    const remaining = bare.progress > 0.005 ? (elapsed * (1 - bare.progress)) / bare.progress : NaN;
    const status = { ...bare, realTimeFactor: this.#playing ? this.#pace.factor : NaN, remaining };
    const clock = this.#pace.clock(this.#playing && run.kind !== "bridge");
    const frame = { kind: "frame", run: this.number, seq: this.#seq, clock, status, ...change, ...this.extras.of(run, now, this.#playing) } as const;
    post(frame, transferables(frame));
  }

  /** Judges the map, slice by slice: it takes a second for an hour's drive. `isWarned`: if the map
      is not good, an event says so too. */
  judge(isWarned = true): void {
    const { run } = this;
    // Reading or judging that is under way comes first.
    if (!run || this.before) return;
    const judgement = run.module.judge();
    if (!judgement) return post({ kind: "quality", run: this.number, quality: null });
    this.before = () => {
      const isOver = this.run !== run;
      const goesOn = !isOver && this.#judgeOn(run, judgement, isWarned);
      if (!goesOn) judgement.free();
      return goesOn;
    };
    this.schedule();
  }

  /** Does one slice of the judgement; returns whether there is more. */
  #judgeOn(run: Run, judgement: WebJudgement, isWarned: boolean): boolean {
    const begin = performance.now();
    while (judgement.step(run.module)) {
      if (performance.now() - begin < SLICE_MILLIS) continue;
      post({ kind: "judging", run: this.number, part: judgement.progress() });
      return true;
    }
    const quality = judgement.quality(run.module) ?? null;
    post({ kind: "quality", run: this.number, quality });
    const text = quality && isWarned ? told(quality) : "";
    if (text !== "") post({ kind: "event", run: this.number, time: run.time, level: "warn", text, topic: "quality" });
    // The run's clock stood still meanwhile.
    this.#rebase();
    return false;
  }

  /** For a recording with true poses: reports the errors of the whole trajectory, as finally
      estimated. */
  #tellTruthErrors(run: Run): void {
    const errors = run.module.truth_curve();
    if (!errors) return;
    post({ kind: "truth-errors", run: this.number, errors });
    post({ kind: "event", run: this.number, time: run.time, level: "info", text: errors.words, topic: "truth" });
  }

  /** Judges the map now and then on the way. Nobody is warned, because a later loop closure may
      repair a tear. */
  #judgeOnTheWay(run: Run): void {
    const { progress } = run.status();
    if (progress < this.#judgedAt * JUDGED_AGAIN || progress < JUDGED_FROM) return;
    this.#judgedAt = progress;
    this.judge(false);
  }

  schedule(now = true): void {
    if (this.#scheduled || !(this.#playing || this.before)) return;
    this.#scheduled = true;
    if (now) this.#immediate.port2.postMessage(null);
    else setTimeout(() => this.#turn(), IDLE_MILLIS);
  }

  #rebase(): void {
    this.#pace.rebase(performance.now(), this.run?.time ?? 0);
  }

  /** One slice of work. */
  #turn(): void {
    this.#scheduled = false;
    try {
      if (this.before) {
        if (!this.before()) this.before = null;
        this.schedule();
      } else if (this.run && this.#playing && this.run.kind !== "bridge") {
        // A live robot sets its own pace: its link reports new messages.
        this.#slice(this.run);
      }
    } catch (error) {
      fail(error);
    }
  }

  #slice(run: Run): void {
    const begin = performance.now();
    const until = this.#until;
    const target = until ? Infinity : Math.min(this.#pace.target(begin), this.#heldAt);
    let late = false;
    while (run.time < target && !run.finished && !late && !until?.(run)) {
      run.step();
      this.#stale = true;
      late = performance.now() - begin >= SLICE_MILLIS;
    }
    // Do not catch up on time spent waiting.
    if (late || run.time >= this.#heldAt) this.#pace.fallBehind(begin, run.time);
    this.#pace.measure(performance.now(), run.time);
    if (run.finished) {
      this.play(false);
      this.#tellTruthErrors(run);
      if (run.kind === "replay") this.judge();
    } else if (until?.(run)) {
      this.play(false);
    } else if (run.kind === "replay") {
      this.#judgeOnTheWay(run);
    }
    this.show();
    this.schedule(late);
  }
}
