// The service worker: keeps the page's own files, all of one build, so that the page opens without
// its server. What a server says of itself (bridge.json, metrics, sockets) is no file of the page;
// such requests pass through untouched.
//
// 1. A build names its files with the hashes of their contents (build.mjs). They are stored when
//    the worker is installed. Files that the last build also had are taken from there; the others
//    are loaded and must have the named content. So two builds are never mixed.
// 2. While a page is open, a new build waits. It takes over when somebody says so, or when the only
//    page is reloaded, before anything has begun in it: never in the middle of a run.

/** Path below the scope to hash: the first hexadecimal digits of SHA-256. */
declare const FILES: Readonly<Record<string, string>>;
/** The name of this set of files. */
declare const BUILD: string;
declare const self: ServiceWorkerGlobalScope;

const scope = new URL(self.registration.scope);
/** Caches belong to an origin, which may have several pages. */
const OURS = `slamlab ${scope.pathname} `;
const hashes: ReadonlyMap<string, string> = new Map(Object.entries(FILES));

/** The key of a file: its name and its content. */
function keyOf(path: string, hash: string): URL {
  const key = new URL(path, scope);
  key.searchParams.set("content", hash);
  return key;
}

async function store(): Promise<void> {
  const cache = await caches.open(OURS + BUILD);
  for (const [path, hash] of hashes) {
    const key = keyOf(path, hash);
    // Of this cache too, so that an interrupted installation goes on.
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

/** The file of this build. If the browser has deleted it, the server's. */
async function answer(request: Request, path: string, hash: string): Promise<Response> {
  const cache = await caches.open(OURS + BUILD);
  return (await cache.match(keyOf(path, hash))) ?? fetch(request);
}

/** Takes over if no page but the asking one is open, and tells it whether it does. */
async function takeOverAlone(asking: MessagePort | undefined): Promise<void> {
  const pages = await self.clients.matchAll({ type: "window", includeUncontrolled: true });
  const isAlone = pages.filter(({ url }) => url.startsWith(scope.href)).length <= 1;
  // Answer first: taking over may have to wait until the old worker has nothing to do.
  asking?.postMessage(isAlone);
  if (isAlone) await self.skipWaiting();
}

self.addEventListener("install", (event) => event.waitUntil(store()));

self.addEventListener("activate", (event) => {
  const tidy = async (): Promise<void> => {
    const names = await caches.keys();
    await Promise.all(names.filter((name) => name.startsWith(OURS) && name !== OURS + BUILD).map((name) => caches.delete(name)));
    // The first worker serves the page that installed it.
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
