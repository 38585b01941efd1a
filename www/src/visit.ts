// What the browser keeps from visit to visit: that there was one, and what of the map is shown.

import { ifAllowed } from "./storage.js";
import type { Store } from "./store.js";
import { LAYERS, type LayerName } from "./view/scene.js";

const VISITED = "slamlab-visited";
const VIEW = "slamlab-view";
const ORDER = "slamlab-order";
const TURN = "slamlab-turn";

/** Whether nobody was here before. Where nothing can be kept nobody is greeted twice, so nobody is
    greeted at all. */
export function isFirstVisit(): boolean {
  return ifAllowed(() => localStorage.getItem(VISITED) ?? "") === "";
}

export function noteVisit(): void {
  ifAllowed(() => localStorage.setItem(VISITED, "1"));
}

/** Shows the layers that were shown last, in their order, and keeps what is chosen from here on. */
export function keepView(store: Store): void {
  const kept = ifAllowed(() => localStorage.getItem(VIEW));
  if (kept) store.layers = { ...store.layers, ...switchesIn(kept) };
  store.layerOrder = orderIn(ifAllowed(() => localStorage.getItem(ORDER)) ?? "");
  store.on("view", () => ifAllowed(() => {
    localStorage.setItem(VIEW, JSON.stringify(store.layers));
    if (store.layerOrder === LAYERS) localStorage.removeItem(ORDER);
    else localStorage.setItem(ORDER, store.layerOrder.join(" "));
  }));
}

/** Turns the map as it was turned last, and keeps how it is turned from here on. */
export function keepTurn(map: { turn(angle: number): void; onTurn: (angle: number) => void }): void {
  const kept = Number(ifAllowed(() => localStorage.getItem(TURN)) ?? NaN);
  if (Math.abs(kept) <= Math.PI) map.turn(kept);
  map.onTurn = (angle) => ifAllowed(() => (angle === 0 ? localStorage.removeItem(TURN) : localStorage.setItem(TURN, String(angle))));
}

/** The order that a text names; ours, if it does not name each layer once. */
function orderIn(text: string): readonly LayerName[] {
  const names = text.split(" ").filter((name): name is LayerName => (LAYERS as readonly string[]).includes(name));
  return names.length === LAYERS.length && new Set(names).size === LAYERS.length ? names : LAYERS;
}

/** The switches that a text names; none of one that is not ours. */
function switchesIn(text: string): Partial<Store["layers"]> {
  try {
    const named = JSON.parse(text) as Record<string, unknown> | null;
    return Object.fromEntries(LAYERS.flatMap((name) => (typeof named?.[name] === "boolean" ? [[name, named[name]]] : [])));
  } catch {
    return {};
  }
}
