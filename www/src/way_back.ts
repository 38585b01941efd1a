// A run that went back and takes another way from there: how it went before is not lost, but
// offered as the link that does it again.

import type { Client } from "./client.js";
import type { Store } from "./store.js";
import { clock } from "./ui/format.js";
import { t } from "./words.js";

export class WayBack {
  /** How far the run came, and its link; null where it did not go back. */
  #way: { readonly time: number; readonly link: Promise<string | null> } | null = null;

  constructor(readonly store: Store, readonly client: Client) {}

  /** Before a simulation goes back from as far as it came. */
  keep(): void {
    const { source, status, furthest, started } = this.store;
    if (source === "sim" && status && status.time >= furthest) this.#way = { time: status.time, link: this.client.linkOf(started) };
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
}
