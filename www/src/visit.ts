// What the browser keeps from visit to visit: that there was one, how the map is shown, which panel
// is open, and the choices for runs: method, settings, speed.

import type { MethodName, SettingValues } from "./protocol/module.js";
import { ofAnySensor } from "./protocol/setup.js";
import { ifAllowed } from "./storage.js";
import { type Store, TABS } from "./store.js";
import { LAYERS, type LayerName } from "./view/scene.js";

const VISITED = "slamlab-visited";
const VIEW = "slamlab-view";
const ORDER = "slamlab-order";
const TURN = "slamlab-turn";
const TAB = "slamlab-tab";
const MAPS = "slamlab-maps";
const CHOICES = "slamlab-choices";

const USUAL_SENSOR = "lidar";

/** Whether this is the first visit. If storage is forbidden, no visit counts as the first, because
    every visit would begin with the tour. */
export function isFirstVisit(): boolean {
  return ifAllowed(() => localStorage.getItem(VISITED) ?? "") === "";
}

export function noteVisit(): void {
  ifAllowed(() => localStorage.setItem(VISITED, "1"));
}

/** Restores the layers last shown, in their order, and keeps changes from here on. */
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

/** Restores the last rotation of the map, and keeps changes from here on. */
export function keepTurn(map: { turn(angle: number): void; onTurn: (angle: number) => void }): void {
  const kept = Number(ifAllowed(() => localStorage.getItem(TURN)) ?? NaN);
  if (Math.abs(kept) <= Math.PI) map.turn(kept);
  map.onTurn = (angle) => ifAllowed(() => (angle === 0 ? localStorage.removeItem(TURN) : localStorage.setItem(TURN, String(angle))));
}

/** Opens the panel that was last open, and keeps changes from here on. To be called once the panels
    listen. */
export function keepTab(store: Store): void {
  const kept = ifAllowed(() => localStorage.getItem(TAB));
  const tab = TABS.find((each) => each === kept);
  if (tab !== undefined) store.set("tab", { tab });
  store.on("tab", () => ifAllowed(() => localStorage.setItem(TAB, store.tab)));
}

/** Whether somebody has opened the fold of submaps and other maps. */
export function mapsAreOpen(): boolean {
  return ifAllowed(() => localStorage.getItem(MAPS)) === "open";
}

export function noteMapsOpen(isOpen: boolean): void {
  ifAllowed(() => (isOpen ? localStorage.setItem(MAPS, "open") : localStorage.removeItem(MAPS)));
}

/** A person's choices for simulated runs. */
interface Choices {
  readonly method?: MethodName;
  readonly settings?: SettingValues;
  readonly speed?: number;
}

/** Keeps a choice. A lesson, an experiment and the tour are not the person's choice, and a robot
    behind a bridge begins as its bridge decides. */
export function noteChoice({ source, tour, exhibit, setup: { lesson, sensor }, settings: infos }: Store, { settings, ...chosen }: Choices): void {
  if (source === "bridge" || tour || exhibit || lesson !== null) return;
  // A visit begins with the usual sensor.
  const kept = settings && { settings: sensor === USUAL_SENSOR ? settings : ofAnySensor(settings, infos) };
  // JSON has no Infinity, which is the highest speed.
  ifAllowed(() => localStorage.setItem(CHOICES, JSON.stringify({ ...choices(), ...chosen, ...kept }, (_, value: unknown) => (value === Infinity ? "max" : value))));
}

/** The choices of earlier visits; the module reports those that it does not know. */
export function choices(): Choices {
  try {
    const { method, settings, speed } = JSON.parse(localStorage.getItem(CHOICES) ?? "{}") as Record<string, unknown>;
    const factor = speed === "max" ? Infinity : Number(speed);
    return {
      ...(typeof method === "string" && { method: method as MethodName }),
      ...(typeof settings === "object" && settings !== null && { settings: settings as SettingValues }),
      ...(factor > 0 && { speed: factor }),
    };
  } catch {
    return {};
  }
}

/** Forgets choices that this build does not accept. Returns whether there were any. */
export function forgetChoices(): boolean {
  const had = Object.keys(choices()).length > 0;
  ifAllowed(() => localStorage.removeItem(CHOICES));
  return had;
}

/** The layer order in a text; the default, unless it names each layer once. */
function orderIn(text: string): readonly LayerName[] {
  const names = text.split(" ").filter((name): name is LayerName => (LAYERS as readonly string[]).includes(name));
  return names.length === LAYERS.length && new Set(names).size === LAYERS.length ? names : LAYERS;
}

/** The switches in a text; unknown ones are left out. */
function switchesIn(text: string): Partial<Store["layers"]> {
  try {
    const named = JSON.parse(text) as Record<string, unknown> | null;
    return Object.fromEntries(LAYERS.flatMap((name) => (typeof named?.[name] === "boolean" ? [[name, named[name]]] : [])));
  } catch {
    return {};
  }
}
