// Loads parts of the page that have bundles of their own, because a first visit does not need them.

import type { Store } from "./store.js";
import { t } from "./words.js";

/** Loads the bundle `name` from beside this one. If that fails, tells the user and returns null.
    `what` begins the sentence of that message. */
export async function bundle(store: Store, name: string, what: string): Promise<unknown> {
  try {
    return await import(new URL(name, import.meta.url).href);
  } catch {
    store.set("toast", { toast: { level: "warn", text: t`${what} could not be loaded. Is the server still there?` } });
    return null;
  }
}
