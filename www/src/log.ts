// The log of a run: every entry is kept, and entries of one topic are shown as one line.

import type { Level } from "./protocol/module.js";

export interface LogEntry {
  readonly time: number;
  readonly level: Level;
  readonly text: string;
  /** Entries with the same topic share one line, which shows the newest. */
  readonly topic?: string;
}

/** The newest entry of a line, and the others that it stands for, the newest first. */
export interface LogLine {
  readonly newest: LogEntry;
  readonly earlier: readonly LogEntry[];
}

/** What is listed: all, or one kind. */
export const KINDS = ["all", "info", "warn", "good"] as const;
export type LogKind = (typeof KINDS)[number];

/** Most entries: an exploration of an hour has some hundred, a bridge may run for days. */
export const MOST_ENTRIES = 2000;

/** The log with one more entry. If there are too many, the oldest that has a newer one on its line
    is dropped, so that a hundred legs of a path do not push out a warning. */
export function withEntry(log: readonly LogEntry[], entry: LogEntry): readonly LogEntry[] {
  const all = [...log, entry];
  if (all.length <= MOST_ENTRIES) return all;
  const left = new Map<string, number>();
  for (const { topic } of all) if (topic !== undefined) left.set(topic, (left.get(topic) ?? 0) + 1);
  const spare = all.findIndex(({ topic }) => topic !== undefined && (left.get(topic) ?? 0) > 1);
  all.splice(Math.max(spare, 0), 1);
  return all;
}

/** Entries of a kind that contain all of these words; `read` gives the text as it is shown. */
export function listed(log: readonly LogEntry[], kind: LogKind, search: string, read: (text: string) => string): readonly LogEntry[] {
  const words = search.toLowerCase().split(/\s+/).filter((word) => word !== "");
  return log.filter(({ level, text }) => (kind === "all" || level === kind) && words.every((word) => read(text).toLowerCase().includes(word)));
}

/** The newest line first. */
export function linesOf(entries: readonly LogEntry[]): readonly LogLine[] {
  const lines: { newest: LogEntry; earlier: LogEntry[] }[] = [];
  const byTopic = new Map<string, LogEntry[]>();
  for (const entry of entries.toReversed()) {
    const of = entry.topic === undefined ? undefined : byTopic.get(entry.topic);
    if (of) {
      of.push(entry);
      continue;
    }
    const line = { newest: entry, earlier: [] };
    if (entry.topic !== undefined) byTopic.set(entry.topic, line.earlier);
    lines.push(line);
  }
  return lines;
}
