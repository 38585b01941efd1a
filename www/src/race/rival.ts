// A run beside the one that is shown: the same world or recording, with another method or setting,
// in a worker and with a map of its own. It follows the run that is shown and does not pass it.

import type { Client } from "../client.js";
import type { Command } from "../protocol.js";
import type { MethodName, SettingValues } from "../protocol/module.js";
import type { Store } from "../store.js";
import type { SlamMap } from "../view/map_view.js";
import type { Scene } from "../view/scene.js";
import { t } from "../words.js";
import type { RunColour } from "./swatch.js";

/** The parts of a run in the page. */
export interface RunParts {
  readonly store: Store;
  readonly scene: Scene;
  readonly client: Client;
  readonly map: SlamMap;
}

/** How it differs from the run that is shown. */
export interface Difference {
  /** Its name in the legend. */
  readonly name: string;
  readonly method: MethodName;
  /** Whether the method differs; otherwise a setting does. */
  readonly isByMethod: boolean;
  readonly settings: SettingValues;
  /** Moment from which the settings apply, s; null: from the beginning. */
  readonly from: number | null;
}

/** Moments closer to each other than this count as one, s. */
const SAME_SECONDS = 1e-3;
/** A run farther ahead than this, s, is ahead because the shown one went back. */
const PASSED = 0.5;

export class Rival {
  /** Whether it has caught up with the run that is shown. */
  isThere = false;
  #hasForked = false;
  /** Commands to be given to it, each at its moment, s. */
  #due: readonly { readonly time: number; readonly command: Command }[] = [];
  #heldAt = NaN;
  #speed = NaN;
  /** Play was requested; not requested again before the module answers. */
  #asksPlay = false;
  /** The recording that it maps; null in a simulation. */
  recording: File | null = null;

  constructor(readonly parts: RunParts, readonly difference: Difference, readonly colour: RunColour) {}

  get time(): number {
    return this.parts.store.status?.time ?? 0;
  }

  get isOver(): boolean {
    return this.parts.store.status?.finished ?? false;
  }

  /** Begins beside the shown run, and repeats what was done there so far. */
  async begin({ store: shown, client: leader }: RunParts): Promise<void> {
    const { store, client } = this.parts;
    const { name, method, settings, from } = this.difference;
    [this.isThere, this.#hasForked, this.#due] = [false, false, []];
    this.#hold(Math.min(from ?? Infinity, shown.status?.time ?? 0));
    this.#pace(Infinity);
    const { recording } = leader.files;
    this.recording = shown.source === "replay" ? recording?.file ?? null : null;
    if (shown.source === "replay") {
      if (!recording) return;
      store.setup = { ...shown.setup, method, settings };
      await client.files.open(recording, method);
      return;
    }
    const setup = { ...shown.started, method, settings: from === null ? settings : shown.started.settings, lesson: null };
    const link = await leader.linkOf(setup);
    if (link !== null) return client.follow(link);
    shown.set("toast", { toast: { level: "info", text: t`${name} begins without what was done by hand: in this run no link can tell that.` } });
    client.start(setup);
  }

  /** Gives a command when it has reached this moment, s. */
  doAt(time: number, command: Command): void {
    this.#due = [...this.#due, { time, command }];
  }

  /** Follows the run that is shown; called for each picture. */
  follow(shown: Store): void {
    const { store: { status, playing, reading, loading, seeking }, client } = this.parts;
    const leader = shown.status;
    if (!status || !leader || reading || loading !== "" || seeking !== null) return;
    const { from, settings } = this.difference;
    if (!this.#hasForked && from !== null && status.time >= from - SAME_SECONDS) {
      this.#hasForked = true;
      client.configure(settings);
    }
    const goal = shown.seeking ?? leader.time;
    if (!leader.finished && status.time > goal + PASSED) return this.#goBack(goal);
    this.isThere ||= status.finished || status.time >= leader.time - PASSED;
    this.#hold(Math.min(this.#hasForked ? Infinity : from ?? Infinity, leader.finished ? Infinity : leader.time));
    // It catches up as fast as it can.
    this.#pace(leader.finished ? shown.speed : Infinity);
    const isDue = ({ time }: { time: number }): boolean => status.time >= time - SAME_SECONDS;
    for (const { command } of this.#due.filter(isDue)) client.relay(command);
    this.#due = this.#due.filter((each) => !isDue(each));
    if (playing) this.#asksPlay = false;
    if (playing || status.finished || this.#asksPlay) return;
    this.#asksPlay = true;
    client.relay({ kind: "play" });
  }

  end(): void {
    this.parts.client.end();
  }

  #goBack(time: number): void {
    [this.isThere, this.#due, this.#asksPlay] = [false, [], false];
    this.parts.client.seek(time);
  }

  #hold(time: number): void {
    if (time === this.#heldAt) return;
    this.#heldAt = time;
    this.parts.client.relay({ kind: "hold-at", time });
  }

  #pace(speed: number): void {
    if (speed === this.#speed) return;
    this.#speed = speed;
    this.parts.client.setSpeed(speed);
  }
}
