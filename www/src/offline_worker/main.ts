// The service worker: keeps the page's own files, all of one build, so that it opens without its
// server. What a server says of itself (bridge.json, metrics, sockets) is no file of the page, and
// passes by untouched.
//
// 1. A build names its files with the hashes of their contents (build.mjs). They are stored when
//    the worker is installed: those that the last build had too are taken from there, the others
//    are loaded and must have the content that was named. So nothing of two builds is ever mixed.
// 2. Where a page is open, a new build waits. It takes over when somebody says so, or when the only
//    page is loaded again, before anything has begun in it: never in the middle of a run.

/** Path below the scope to hash: hexadecimal digits of SHA-256, from the first on. */
declare const FILES: Readonly<Record<string, string>>;
/** What all of them together are called. */
declare const BUILD: string;
declare const self: ServiceWorkerGlobalScope;

const scope = new URL(self.registration.scope);
/** Caches belong to an origin, which may have several pages. */
const OURS = `slamlab ${scope.pathname} `;
const hashes: ReadonlyMap<string, string> = new Map(Object.entries(FILES));

/** Under what a file is stored: what it is called, and what is in it. */
function keyOf(path: string, hash: string): URL {
  const key = new URL(path, scope);
  key.searchParams.set("content", hash);
  return key;
}

async function store(): Promise<void> {
  const cache = await caches.open(OURS + BUILD);
  for (const [path, hash] of hashes) {
    const key = keyOf(path, hash);
    // Of this cache too: an installation that was broken off goes on.
    const kept = await caches.match(key);
    await cache.put(key, kept ?? (await load(path, hash)));
  }
}

async function load(path: string, hash: string): Promise<Response> {
  const url = new URL(path, scope);
  const response = await fetch(url, { cache: "no-cache", credentials: "same-origin" });
  if (!response.ok) throw new Error(`${url.pathname}: the server answers ${response.status}`);
  const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", await response.clone().arrayBuffer()));
  const found = Array.from(digest, (byte) => byte.toString(16).padStart(2, "0")).join("");
  if (!found.startsWith(hash)) throw new Error(`${url.pathname} is of another build than this worker`);
  return response;
}

/** The file as this build has it. The browser may have thrown it away: then as the server does. */
async function answer(request: Request, path: string, hash: string): Promise<Response> {
  const cache = await caches.open(OURS + BUILD);
  return (await cache.match(keyOf(path, hash))) ?? fetch(request);
}

/** Takes over where no page but the one that asks is open, and says whether it does. */
async function takeOverAlone(asking: MessagePort | undefined): Promise<void> {
  const pages = await self.clients.matchAll({ type: "window", includeUncontrolled: true });
  const isAlone = pages.filter(({ url }) => url.startsWith(scope.href)).length <= 1;
  // Before: to take over may take until the worker of before has nothing to do.
  asking?.postMessage(isAlone);
  if (isAlone) await self.skipWaiting();
}

self.addEventListener("install", (event) => event.waitUntil(store()));

self.addEventListener("activate", (event) => {
  const tidy = async (): Promise<void> => {
    const names = await caches.keys();
    await Promise.all(names.filter((name) => name.startsWith(OURS) && name !== OURS + BUILD).map((name) => caches.delete(name)));
    // The first one serves the page that brought it.
    await self.clients.claim();
  };
  event.waitUntil(tidy());
});

self.addEventListener("message", (event) => {
  if (event.data === "take over") event.waitUntil(self.skipWaiting());
  else if (event.data === "take over alone") event.waitUntil(takeOverAlone(event.ports[0]));
});

self.addEventListener("fetch", (event) => {
  const { request } = event;
  const url = new URL(request.url);
  if (request.method !== "GET" || url.origin !== scope.origin || !url.pathname.startsWith(scope.pathname)) return;
  const below = url.pathname.slice(scope.pathname.length);
  const path = below === "index.html" ? "" : below;
  const hash = hashes.get(path);
  if (hash === undefined) return;
  event.respondWith(answer(request, path, hash));
});

export {};
