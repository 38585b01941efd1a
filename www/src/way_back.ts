// A run that went back and took another way, or was replaced by another run, is not lost: it is
// offered as the link that repeats it.

import type { Client } from "./client.js";
import type { Store } from "./store.js";
import { clock } from "./ui/format.js";
import { t } from "./words.js";
import { titleOf } from "./worlds.js";

/** Nobody misses a shorter run, s. */
export const LEAST_SECONDS = 20;
/** How long the last run is offered, wall milliseconds: who wanted a new one sees its map. */
const OFFERED_MILLIS = 20_000;

/** How far a run came, s, and the link that repeats it. */
interface Way { readonly title: string; readonly time: number; readonly link: Promise<string | null> }

export class WayBack {
  /** How far the run came, and its link; null if it did not go back. */
  #way: Way | null = null;
  /** The run before, if it was long enough to be missed. */
  #before: Way | null = null;

  constructor(readonly store: Store, readonly client: Client) {}

  /** To be called before a simulation goes back from its furthest time. */
  keep(): void {
    const { source, status, furthest } = this.store;
    if (source === "sim" && status && status.time >= furthest) this.#way = this.#wayOf(status.time);
  }

  /** To be called before another simulation replaces the one that is shown. A short run does not
      replace the one kept before: arrow keys in a list of worlds start several. */
  leave(): void {
    const { source, status } = this.store;
    if (source === "sim" && status && status.time >= LEAST_SECONDS) this.#before = this.#wayOf(status.time);
  }

  #wayOf(time: number): Way {
    return { title: titleOf(this.store.started), time, link: this.client.linkOf(this.store.started) };
  }

  /** To be called once the run has taken another way. */
  async offer(): Promise<void> {
    const way = this.#way;
    this.#way = null;
    const link = await way?.link;
    if (!way || !link) return;
    const text = t`From here the run goes another way. It had come as far as ${clock(way.time)}.`;
    this.store.set("toast", { toast: { level: "info", text, way: { label: t("Back to how it went"), go: () => this.client.follow(link, way.time) } } });
  }

  /** To be called once another simulation has replaced it. */
  async offerBefore(): Promise<void> {
    const way = this.#before;
    const link = await way?.link;
    // Messages of the new run take precedence.
    if (!way || !link || way !== this.#before || this.store.toast) return;
    const go = (): void => {
      this.#before = null;
      this.client.follow(link, way.time);
    };
    offerRun(this.store, way, go);
  }
}

/** Offers, for a while, the run that was replaced by the one that is shown. */
export function offerRun(store: Store, { title, time }: Pick<Way, "title" | "time">, go: () => void): void {
  const text = t`The run before, in ${title}, had come as far as ${clock(time)}.`;
  store.set("toast", { toast: { level: "info", text, way: { label: t("Back to the run before"), go }, stands: OFFERED_MILLIS } });
}
