// A run that went back and takes another way from there, or that another one took the place of: how
// it went is not lost, but offered as the link that does it again.

import type { Client } from "./client.js";
import type { Store } from "./store.js";
import { clock } from "./ui/format.js";
import { t } from "./words.js";
import { titleOf } from "./worlds.js";

/** A shorter run is none that somebody misses, s. */
export const LEAST_SECONDS = 20;
/** So long the run before is offered, wall milliseconds: who wanted another one sees its map. */
const OFFERED_MILLIS = 20_000;

/** How far a run came, s, and the link that does it again. */
interface Way { readonly title: string; readonly time: number; readonly link: Promise<string | null> }

export class WayBack {
  /** How far the run came, and its link; null where it did not go back. */
  #way: Way | null = null;
  /** The run before, if it was long enough to be missed. */
  #before: Way | null = null;

  constructor(readonly store: Store, readonly client: Client) {}

  /** Before a simulation goes back from as far as it came. */
  keep(): void {
    const { source, status, furthest } = this.store;
    if (source === "sim" && status && status.time >= furthest) this.#way = this.#wayOf(status.time);
  }

  /** Before another simulation takes the place of the one that is shown. Shorter ones leave the one
      before them: in a list of worlds arrow keys go through several. */
  leave(): void {
    const { source, status } = this.store;
    if (source === "sim" && status && status.time >= LEAST_SECONDS) this.#before = this.#wayOf(status.time);
  }

  #wayOf(time: number): Way {
    return { title: titleOf(this.store.started), time, link: this.client.linkOf(this.store.started) };
  }

  /** Once it has taken another way. */
  async offer(): Promise<void> {
    const way = this.#way;
    this.#way = null;
    const link = await way?.link;
    if (!way || !link) return;
    const text = t`From here the run goes another way. It had come as far as ${clock(way.time)}.`;
    this.store.set("toast", { toast: { level: "info", text, way: { label: t("Back to how it went"), go: () => this.client.follow(link, way.time) } } });
  }

  /** Once another simulation has taken its place. */
  async offerBefore(): Promise<void> {
    const way = this.#before;
    const link = await way?.link;
    // What is said of the new run goes before.
    if (!way || !link || way !== this.#before || this.store.toast) return;
    const go = (): void => {
      this.#before = null;
      this.client.follow(link, way.time);
    };
    offerRun(this.store, way, go);
  }
}

/** Offers, for a while, the run that the one which is shown took the place of. */
export function offerRun(store: Store, { title, time }: Pick<Way, "title" | "time">, go: () => void): void {
  const text = t`The run before, in ${title}, had come as far as ${clock(time)}.`;
  store.set("toast", { toast: { level: "info", text, way: { label: t("Back to the run before"), go }, stands: OFFERED_MILLIS } });
}
