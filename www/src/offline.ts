// The page's files, kept by the browser so that the page opens without its server (offline_worker),
// and what happens to them when the server has a newer build.

import { faultOf } from "./fault.js";
import type { Store } from "./store.js";

/** What is available without a server. */
export type Offline =
  /** Nothing, and why. */
  | { kind: "none"; why: string }
  /** Its files will be stored, or are being stored. */
  | { kind: "storing" }
  /** The whole page. */
  | { kind: "kept" };

/** A build other than the one that is shown: it waits, or another window let it take over. */
export type Renewal = "waits" | "took over" | null;

/** Milliseconds after the first frame: what a first visit shows comes first. */
const REST_MILLIS = 3000;
/** Timeout for an answer of a worker, milliseconds. */
const ANSWER_MILLIS = 1000;

let registered: ServiceWorkerRegistration | null = null;
/** Somebody asked here for the newer build to take over. */
let isAskedFor = false;
const watched = new WeakSet<ServiceWorker>();

/** A waiting build takes over before anything has begun, if no other page is open; the page is then
    reloaded. */
export async function renewFirst(): Promise<boolean> {
  const { serviceWorker } = navigator;
  // Service workers need https or this computer's own address.
  if (!serviceWorker?.controller) return false;
  // A browser that is busy with another build answers late, or never: do not wait for it.
  const waiting = (await soon(serviceWorker.getRegistration()))?.waiting;
  if (!waiting) return false;
  const { port1, port2 } = new MessageChannel();
  const changed = new Promise<true>((done) => serviceWorker.addEventListener("controllerchange", () => done(true), { once: true }));
  const takesOver = await new Promise<boolean>((answered) => {
    port1.onmessage = ({ data }) => answered(data === true);
    setTimeout(() => answered(false), ANSWER_MILLIS);
    waiting.postMessage("take over alone", [port2]);
  });
  if (!takesOver || !(await soon(changed))) return false;
  location.reload();
  return true;
}

/** The value of the promise, if it comes within a second. */
function soon<T>(promised: Promise<T>): Promise<T | undefined> {
  return Promise.race([promised, new Promise<undefined>((late) => setTimeout(() => late(undefined), ANSWER_MILLIS))]);
}

/** Keeps the page, once the robot is visible and the browser is idle. */
export function keepForOffline(store: Store): void {
  if (!navigator.serviceWorker) {
    return tell(store, "this browser keeps a page only where its address begins with https or is this computer's own");
  }
  let isBegun = false;
  store.on("frame", () => {
    if (isBegun) return;
    isBegun = true;
    setTimeout(() => whenIdle(() => void register(store)), REST_MILLIS);
  });
}

/** Asks the server whether it has a newer build: a bridge that comes back may be another one. */
export async function lookForNewer(store: Store): Promise<void> {
  const found = registered;
  if (!found) return;
  // Not awaited: some browsers delay it for as long as they run.
  void found.update().then(() => note(store, found), () => undefined);
  await compare(store);
}

async function compare(store: Store): Promise<void> {
  if (store.renewal === null && (await isNewerThere())) store.set("offline", { renewal: "waits" });
}

/** Lets the waiting build take over at once. */
export function renew(): void {
  isAskedFor = true;
  if (registered?.waiting) registered.waiting.postMessage("take over");
  else void forget();
}

/** Caches of this page, named by their builds (offline_worker). */
async function kept(): Promise<string[]> {
  const ours = `slamlab ${new URL("./", location.href).pathname} `;
  return (await caches.keys()).filter((name) => name.startsWith(ours));
}

/** Whether the server has a build other than a kept one. */
async function isNewerThere(): Promise<boolean> {
  const answer = await fetch("offline_worker.js", { cache: "no-store" }).catch(() => null);
  if (!answer?.ok) return false;
  const [text, names] = [await answer.text(), await kept()];
  return names.some((name) => !text.includes(name.split(" ").at(-1) ?? ""));
}

/** Deletes what was kept, so that everything comes from the server again, and is the newest. */
async function forget(): Promise<void> {
  await Promise.all((await kept()).map((name) => caches.delete(name)));
  location.reload();
}

function whenIdle(act: () => void): void {
  // Safari has no idle callbacks.
  if ("requestIdleCallback" in window) requestIdleCallback(act, { timeout: 10_000 });
  else setTimeout(act);
}

function tell(store: Store, why: string): void {
  store.set("offline", { offline: { kind: "none", why } });
}

async function register(store: Store): Promise<void> {
  const { serviceWorker } = navigator;
  // If there is one, a worker that takes over later is another build.
  let hadOne = serviceWorker.controller !== null;
  if (!hadOne && (navigator as { connection?: { saveData?: boolean } }).connection?.saveData) {
    return tell(store, "this browser is told to save data");
  }
  serviceWorker.addEventListener("controllerchange", () => {
    if (hadOne && isAskedFor) location.reload();
    else if (hadOne) store.set("offline", { renewal: "took over" });
    hadOne = true;
  });
  try {
    const earlier = await serviceWorker.getRegistration();
    if (earlier && (await isSomethingElse(earlier))) return;
    if (hadOne) await compare(store);
    registered = await serviceWorker.register("offline_worker.js", { updateViaCache: "none" });
  } catch (error) {
    // Without a server, the page that is shown is the kept one.
    if (hadOne) store.set("offline", { offline: { kind: "kept" } });
    else tell(store, faultOf(error).text);
    return;
  }
  const found = registered;
  note(store, found);
  found.addEventListener("updatefound", () => note(store, found));
}

/** The server at this address is another program by now, as happens with ports of one computer:
    delete what was kept of this page. */
async function isSomethingElse(earlier: ServiceWorkerRegistration): Promise<boolean> {
  const answer = await fetch("offline_worker.js", { method: "HEAD", cache: "no-store" }).catch(() => null);
  if (answer?.status !== 404) return false;
  // Not awaited: some browsers delay it for as long as they run. Without the kept files, the old
  // worker hides nothing.
  void earlier.unregister();
  await forget();
  return true;
}

/** Derives from the present workers what they mean for the page. */
function note(store: Store, registration: ServiceWorkerRegistration): void {
  const { installing, waiting, active } = registration;
  if (installing && !watched.has(installing)) {
    watched.add(installing);
    installing.addEventListener("statechange", () => {
      if (installing.state === "redundant" && !registration.active) tell(store, "a file did not come, or there is no room for it");
      else note(store, registration);
    });
  }
  const isOther = store.renewal === "took over";
  store.set("offline", {
    offline: active?.state === "activated" ? { kind: "kept" } : { kind: "storing" },
    renewal: isOther ? "took over" : waiting && active ? "waits" : store.renewal,
  });
}
