// Loaded maps and paths that are shown beside the drawn map: where they lie in it, and which of
// them are visible.

import type { Client } from "./client.js";
import type { Answer } from "./protocol.js";
import type { LoadedMap, Store } from "./store.js";
import { t } from "./words.js";

/** An answer of the worker. */
type Told<Kind extends Answer["kind"]> = Extract<Answer, { kind: Kind }>;

export class LoadedMaps {
  constructor(private readonly client: Client, private readonly store: Store) {}

  /** Aligns one of them again. */
  align(id: number): void {
    this.#patch(id, { isAligning: true });
    this.client.send({ kind: "align-map", id });
  }

  drop(id: number): void {
    this.client.send({ kind: "drop-map", id });
    this.#set(this.store.loadedMaps.filter((map) => map.id !== id));
  }

  show(id: number, shown: boolean): void {
    this.#patch(id, { shown });
  }

  /** Adds one whose place is being searched for. */
  loaded({ id, name, picture, path }: Told<"map-loaded">): void {
    this.#set([...this.store.loadedMaps, { id, name, picture, path, shown: true, alignment: null, error: "", isAligning: true }]);
    if (path) this.#tell(name, path);
  }

  aligned({ id, alignment, error }: Told<"map-aligned">): void {
    this.#patch(id, { alignment, error, isAligning: false });
  }

  #set(loadedMaps: readonly LoadedMap[]): void {
    this.store.set("submaps", { loadedMaps });
  }

  #patch(id: number, patch: Partial<LoadedMap>): void {
    this.#set(this.store.loadedMaps.map((map) => (map.id === id ? { ...map, ...patch } : map)));
  }

  #tell(name: string, { poses, seconds, repeated }: NonNullable<LoadedMap["path"]>): void {
    const text = t`${name}: a path of ${poses} poses in ${seconds.toFixed(0)} s is drawn beside the way of the run; Run says how it lies.`;
    const left = repeated > 0 ? ` ${t`${repeated} more have the same time as another one, and were left out.`}` : "";
    this.client.note("good", `${text}${left}`);
    this.store.set("toast", { toast: { level: "good", text } });
  }
}
