// Parts of the page that are bundles of their own: a first visit does without them.

import type { Store } from "./store.js";
import { t } from "./words.js";

/** Loads a part, which stands beside this one; null where it does not come, and then a person was
    told. `what` begins a sentence. */
export async function bundle(store: Store, name: string, what: string): Promise<unknown> {
  try {
    return await import(new URL(name, import.meta.url).href);
  } catch {
    store.set("toast", { toast: { level: "warn", text: t`${what} could not be loaded. Is the server still there?` } });
    return null;
  }
}
