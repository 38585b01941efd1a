// Lessons: runs with a fault that the visitor has to repair, graded by the core.

import type { Client } from "./client.js";
import type { LessonInfo, SettingValues } from "./protocol/module.js";
import { ifAllowed } from "./storage.js";
import type { Store } from "./store.js";

const ADDRESS = "#lesson=";
const PASSED = "slamlab-lessons";
/** Fast enough for a room to take some seconds. */
const SPEED = 4;

/** The address of a lesson, to be appended to that of the page: teachers pass it on. */
export const addressOf = ({ name }: Pick<LessonInfo, "name">): string => ADDRESS + name;

/** The name of the lesson at an address; `null` if there is none. */
export const lessonAt = (hash: string): string | null => (hash.startsWith(ADDRESS) ? hash.slice(ADDRESS.length) : null);

/** The lesson that the run is an attempt at, and its index among all. */
export function current({ source, started, setup, offer }: Store): { lesson: LessonInfo; place: number } | null {
  // A lesson that was left is over, even if its run goes on.
  if (source !== "sim" || setup.lesson === null || started.lesson !== setup.lesson) return null;
  const place = offer.lessons.findIndex(({ name }) => name === setup.lesson);
  const lesson = offer.lessons[place];
  return lesson ? { lesson, place } : null;
}

/** Begins a lesson with its setup. */
export function teach(store: Store, client: Client, { setup }: LessonInfo): void {
  store.set("exhibit", { exhibit: null });
  store.setLayers({ truth: true, trails: true, wheels: false });
  client.setSpeed(SPEED);
  client.start(setup);
}

/** Leaves the lesson: the run stays as it is, and the next one is without its fault. */
export function leave(store: Store): void {
  store.set("lesson", { setup: { ...store.setup, lesson: null, settings: withoutFault(store) } });
}

/** The settings without those that a lesson began with: nobody chose its fault. */
export function withoutFault({ offer, setup: { lesson, settings } }: Pick<Store, "offer" | "setup">): SettingValues {
  const fault = offer.lessons.find(({ name }) => name === lesson)?.setup.settings ?? {};
  return Object.fromEntries(Object.entries(settings).filter(([key, value]) => fault[key] !== value));
}

/** Names of the lessons passed in this browser. */
export function passed(): ReadonlySet<string> {
  return new Set((ifAllowed(() => localStorage.getItem(PASSED)) ?? "").split(" ").filter((name) => name !== ""));
}

export function notePassed(name: string): void {
  ifAllowed(() => localStorage.setItem(PASSED, [...new Set([...passed(), name])].join(" ")));
}
