// One run, whatever its source: a simulation and a recording are stepped, a live robot is fed by
// its link.

import { turnBetween } from "../angle.js";
import type { Change, Renumbering, Status } from "../protocol/frame.js";
import type { MethodName, RunStatus, SourceKind, WebRun } from "../protocol/module.js";
import { sampleOf } from "../protocol/sample.js";
import { Changes } from "./changes.js";
import { Slow } from "./feeds.js";
import { doing, type Note, OF_THE_LINK, Story } from "./story.js";

/** In a world larger than this, m², counting the reachable area would take too long; the known area
    is still given. */
const MOST_EXTENT = 10_000;

/** Moments closer than this are one, s: stamps are whole microseconds, and the page rounds them. */
const SAME_SECONDS = 1e-6;

/** A status without the pace, which only the player knows. */
type PacelessStatus = Omit<Status, "realTimeFactor" | "remaining">;

export interface RunFacts {
  readonly kind: SourceKind;
  readonly title: string;
  readonly method: MethodName;
}

export class Run implements RunFacts {
  readonly kind: SourceKind;
  readonly title: string;
  readonly method: MethodName;
  readonly #story: Story;
  readonly #changes: Changes;
  readonly #explored: Slow;
  readonly #knownArea: Slow;
  #status: RunStatus;
  #isCompared = false;
  #ended: "" | "end of the recording" | "cancelled" = "";
  /** Stamp of the last scan of a recording, once it is known. */
  #lastScanAt = Infinity;

  constructor(readonly module: WebRun, { kind, title, method }: RunFacts, private readonly begins: string, private readonly noted: readonly string[] = []) {
    [this.kind, this.title, this.method] = [kind, title, method];
    module.draw_dead_reckoned();
    this.#story = new Story(module);
    this.#changes = new Changes(module, kind === "replay");
    const countable = module.extent() < MOST_EXTENT;
    this.#explored = new Slow(() => (countable ? module.explored() : NaN));
    this.#knownArea = new Slow(() => module.known_area());
    this.#status = module.status();
    if (begins !== "") this.#story.note("info", begins);
    for (const note of noted) this.#story.note("info", note);
    this.update(0);
  }

  /** The same run from its beginning. */
  again(): Run {
    const again = new Run(this.module.again(), this, this.begins, this.noted);
    again.#lastScanAt = this.#lastScanAt;
    return again;
  }

  /** Seconds of simulation, recording or robot so far. */
  get time(): number {
    return this.#status.time;
  }

  get scans(): number {
    return this.#status.scans;
  }

  /** Whether it has reached a moment, s. The last scan of a recording is reached only at its end,
      when all deferred work is done. */
  isAt(time: number): boolean {
    return this.time >= time - SAME_SECONDS && (this.finished || this.time < this.#lastScanAt);
  }

  /** Whether there is nothing to step: a simulated task or a recording is over. A live robot goes
      on sending readings. */
  get finished(): boolean {
    return this.kind === "sim" ? this.#status.finished && !this.module.has_due() : this.#ended !== "";
  }

  /** Grows with everything that may change the filter's state: scans, and the stages of a scan in
      the cycle. */
  get version(): number {
    return this.scans + this.module.cycle_count();
  }

  /** The smallest step forward. */
  step(): void {
    if (this.finished || this.kind === "bridge") return;
    this.#advance();
  }

  /** One more period of a finished simulation, so that changes in its world become visible. */
  settle(): void {
    if (this.kind === "sim" && this.finished) this.#advance();
  }

  #advance(): void {
    this.module.decide();
    // Planning is not counted: the plot shows the time for a scan.
    const begin = performance.now();
    const more = this.module.advance();
    this.update(performance.now() - begin);
    if (!more) this.#end("end of the recording");
  }

  /** Goes on to the end of the next stage of the cycle. */
  nextStage(): void {
    const begin = performance.now();
    const stage = this.module.next_stage();
    this.update(performance.now() - begin);
    if (!stage) return;
    this.#story.note("info", `${stage}: ${this.module.cycle().stages.find((s) => s.stage === stage)?.text ?? ""}`);
  }

  /** Ends a recording here; the map stays. */
  cancel(): void {
    if (this.kind === "replay" && !this.finished) this.#end("cancelled");
  }

  /** Gives a command, with its words in the log. Its effects are shown at once, and a task that had
      ended is alive again. */
  command(act: (module: WebRun) => void, words = ""): void {
    act(this.module);
    if (words !== "") this.#story.note("info", words);
    this.#changes.refresh();
    this.#story.commanded();
    this.update(0);
  }

  /** Edits the map, with words for the log. */
  changeMap(act: (module: WebRun) => void, words: string): void {
    act(this.module);
    this.#story.note("info", words);
    this.#refresh();
  }

  /** Removes a submap from the map. */
  removeSubmap(submap: number): Renumbering {
    this.module.remove_submap(submap);
    return this.#renumber({ submap, by: -1 }, "taken out of the map");
  }

  /** Puts back the submap that was removed last, if there is one. */
  undoRemoval(): Renumbering | null {
    const submap = this.module.undo_removal();
    return submap === undefined ? null : this.#renumber({ submap, by: 1 }, "put back into the map");
  }

  #renumber(renumbering: Renumbering, done: string): Renumbering {
    this.#changes.renumber(renumbering);
    this.#story.note("info", `Submap ${renumbering.submap} was ${done} by hand`);
    this.#refresh();
    return renumbering;
  }

  /** Starts a new twin if `on`, or removes the present one. */
  setTwin(on: boolean): void {
    this.module.set_twin(on);
    this.#changes.twinReset();
  }

  notes(): Note[] {
    return this.#story.take();
  }

  status(): PacelessStatus {
    // A person's action while it waits counts at once.
    const s = { ...this.#status, byHand: this.module.status().byHand };
    const finished = this.kind === "replay" ? this.finished : s.finished;
    return {
      ...s, finished, source: this.kind,
      reason: finished ? s.task?.text ?? this.#ended : "",
      activity: finished ? "" : doing(s),
      positionError: Math.hypot(s.x - s.truthX, s.y - s.truthY), headingError: turnBetween(s.heading, s.truthHeading),
      odometryError: Math.hypot(s.odometryX - s.truthX, s.odometryY - s.truthY),
      explored: this.#explored.value, knownArea: this.#knownArea.value, features: this.#changes.features,
    };
  }

  change(): Change {
    return this.#changes.take(this.version, this.#ended !== "");
  }

  /** The module of a live run is not freed: it belongs to the conversation. */
  close(): void {
    if (this.kind !== "bridge") this.module.free();
  }

  /** Called after each step; `scanMillis` is the time that it took, NaN if not measured. */
  update(scanMillis: number): void {
    const before = this.#status;
    const s = (this.#status = this.module.status());
    this.#compare();
    this.#changes.follow(s);
    if (s.scans > before.scans) {
      this.#story.scanned(s);
      this.#changes.samples.add(sampleOf(s, scanMillis, this.#explored.value));
    }
    this.#story.update(s, (recompute) => {
      if (recompute) this.#refresh();
      return this.#explored.value;
    });
  }

  /** Reports once whether a run that follows a link reached the same state. */
  #compare(): void {
    const holds = this.#isCompared ? undefined : this.module.link_holds();
    if (holds === undefined) return;
    this.#isCompared = true;
    if (holds) this.#story.tell("good", "Here the link was made, and the state is the same, to the bit.", OF_THE_LINK);
    else this.#story.tell("warn", "Here the link was made, but the state is not the one that it tells: it was made by another version of slamlab.", OF_THE_LINK);
  }

  #refresh(): void {
    this.#explored.refresh();
    this.#knownArea.refresh();
  }

  #end(how: "end of the recording" | "cancelled"): void {
    this.#ended = how;
    if (how === "end of the recording") this.#lastScanAt = this.time;
    // The last picture stays: it must show the final area.
    this.#refresh();
    if (how === "cancelled") this.#story.note("warn", `Cancelled after ${this.scans} scans; the map so far stays`);
    else this.#story.note("good", `End of the recording: ${this.scans} scans mapped`);
  }
}
