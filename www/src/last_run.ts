// The run that was under way when the page was left: kept in this browser, and offered on the next
// visit. A simulation is kept as a link that repeats it, a recording with its file.

import type { Client } from "./client.js";
import type { Recording } from "./files.js";
import type { MethodName, SettingValues, Setup } from "./protocol/module.js";
import { ifAllowed } from "./storage.js";
import type { Store } from "./store.js";
import { LEAST_SECONDS, offerRun } from "./way_back.js";
import { t } from "./words.js";
import { worldTitle } from "./worlds.js";

const KEY = "slamlab-last-run";
const DATABASE = "slamlab";
const FILES = "files";
const RECORDING = "recording";
/** Interval at which the run is kept, wall milliseconds. */
const KEEPS_EVERY = 3000;
/** The last run is offered for at least this long, however fast the new run goes, wall
    milliseconds. */
const OFFERED_MILLIS = 15_000;
/** A larger recording is not kept, bytes: browsers allow a page little more storage. */
const MOST_BYTES = 256e6;

interface Told { readonly title: string; readonly method: MethodName; /** s of the run. */ readonly time: number }
/** `link` is null if no link can describe what was done: then the run begins again from `setup`. */
export type LastSimulation = Told & { readonly kind: "sim"; readonly link: string | null; readonly setup: Setup };
export type LastRecording = Told & { readonly kind: "replay"; readonly settings: SettingValues };
export type LastRun = LastSimulation | LastRecording;

/** The run that was left, if there is one. */
export function lastRun(): LastRun | null {
  try {
    const last = JSON.parse(localStorage.getItem(KEY) ?? "null") as LastRun | null;
    const isOne = last && (last.kind === "sim" || last.kind === "replay") && typeof last.title === "string" && Number.isFinite(last.time);
    return isOne ? last : null;
  } catch {
    // Storage is forbidden, or the value is not ours.
    return null;
  }
}

/** The name of its world or recording on the page. */
export const shownTitle = (last: LastRun): string => (last.kind === "sim" && last.setup?.worldJson === null ? worldTitle(last.title) : last.title);

/** Keeps the run from here on. The last run is offered until there is a new run to be kept in its
    place. */
export function keepLastRun(store: Store, client: Client): void {
  let offeredAt = 0;
  store.on("last", () => (offeredAt = performance.now()));
  let [kept, isKept] = [null as Recording | null, false];
  let keptAt = "";
  setInterval(() => {
    const { source, status, lastRun: offered } = store;
    if (!status || status.time < LEAST_SECONDS) return;
    if (offered && performance.now() - offeredAt < OFFERED_MILLIS) return;
    if (offered) {
      store.set("last", { lastRun: null });
      if (!store.toast) offerRun(store, { title: shownTitle(offered), time: offered.time }, () => void goOn(store, client, offered));
    }
    // A link may hold a whole world, so a run that stands still and is not touched is not written
    // again.
    const at = `${status.time} ${status.byHand}`;
    if (source === "sim" && at !== keptAt) client.send({ kind: "keep", setup: store.started });
    keptAt = at;
    const { recording } = client.files;
    if (source !== "replay" || !recording) return;
    if (recording !== kept) {
      [kept, isKept] = [recording, false];
      void keepRecording(recording).then(() => (isKept = true));
    }
    // A run is offered only once its recording is stored.
    if (!isKept) return;
    const { title, method, setup: { settings } } = store;
    keep({ kind: "replay", title, method, time: status.time, settings });
  }, KEEPS_EVERY);
}

/** The link of a simulation that is under way. */
export function keepSimulation({ title, method, status, started, lastRun: offered }: Store, link: string | null): void {
  if (!offered && status) keep({ kind: "sim", title, method, time: status.time, link, setup: started });
}

/** Continues the last run. */
export async function goOn(store: Store, client: Client, last = store.lastRun): Promise<void> {
  store.set("last", { lastRun: null });
  if (last?.kind === "sim") return last.link === null ? client.start(last.setup) : client.follow(last.link, last.time);
  if (last?.kind !== "replay") return;
  const recording = await keptRecording();
  if (!recording) {
    store.set("toast", { toast: { level: "warn", text: t`The browser did not keep ${last.title}: open it again.` } });
    return;
  }
  store.set("settings", { setup: { ...store.setup, settings: last.settings } });
  await client.files.open(recording, last.method);
}

function keep(last: LastRun): void {
  ifAllowed(() => localStorage.setItem(KEY, JSON.stringify(last)));
}

async function keepRecording(recording: Recording): Promise<void> {
  if (recording.file.size + (recording.poses?.file.size ?? 0) > MOST_BYTES) return;
  // A browser without room for it keeps nothing, and says so when asked for it.
  await inFiles("readwrite", (files) => files.put(recording, RECORDING)).catch(() => {});
}

const keptRecording = (): Promise<Recording | null> =>
  inFiles<Recording | undefined>("readonly", (files) => files.get(RECORDING)).then((kept) => (kept?.file instanceof File ? kept : null), () => null);

function inFiles<T>(mode: IDBTransactionMode, ask: (files: IDBObjectStore) => IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    const opening = indexedDB.open(DATABASE, 1);
    opening.onupgradeneeded = () => opening.result.createObjectStore(FILES);
    opening.onerror = () => reject(opening.error ?? new Error("no storage"));
    opening.onsuccess = () => {
      const database = opening.result;
      const transaction = database.transaction(FILES, mode);
      const request = ask(transaction.objectStore(FILES));
      transaction.oncomplete = () => resolve(request.result);
      transaction.onabort = () => reject(transaction.error ?? new Error("no room"));
      // Close waits for the transaction.
      database.close();
    };
  });
}
