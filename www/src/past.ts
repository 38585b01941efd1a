// What is known of a run's past, and of what followed the moment that it went back to.

import type { LogEntry } from "./log.js";
import type { Store } from "./store.js";

/** A moment that is marked on the time line. */
export type Mark = Pick<LogEntry, "time" | "level" | "text">;

/** Marks closer to each other than this share of the line would overlap. */
const APART = 1 / 250;
/** Most marks; beyond that the older ones of those close together are dropped. */
const MOST = 400;

/** From the beginning to the furthest time of the run, or to the end of its recording, s. */
export function span({ status, furthest, source }: Store): number {
  if (!status) return 0;
  const { time, progress } = status;
  // A recording's length follows from the part that is done.
  const whole = source === "replay" && progress > 0 && !status.finished ? time / progress : time;
  return Math.max(whole, furthest);
}

/** The marks with one more; events that somebody waited for and failures get a mark. A run that
    repeats itself reports the same again. */
export function marked(marks: readonly Mark[], { time, level, text }: Mark): readonly Mark[] {
  if (level === "info" || marks.some((mark) => mark.time === time && mark.text === text)) return marks;
  const all = [...marks, { time, level, text }].sort((a, b) => a.time - b.time);
  if (all.length <= MOST) return all;
  const least = (all.at(-1)?.time ?? 0) * APART;
  return all.filter((mark, at) => mark.level === "warn" || at === 0 || mark.time - (all[at - 1]?.time ?? 0) >= least).slice(-MOST);
}
