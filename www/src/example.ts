// The recording that the page has by itself, for who has none at hand. It comes when it is asked
// for (www/examples/make.mjs tells how it was made).

import type { Client } from "./client.js";
import type { Store } from "./store.js";
import { t } from "./words.js";

const FILE = "examples/ring.gzip";
/** What is in it, as its log is called. */
export const EXAMPLE = "ring.log";

export async function openExample(store: Store, client: Client): Promise<void> {
  try {
    const answer = await fetch(new URL(FILE, import.meta.url));
    if (!answer.ok) throw new Error(answer.statusText);
    await client.files.openAll([new File([await answer.blob()], EXAMPLE)]);
  } catch {
    store.set("toast", { toast: { level: "warn", text: t`${"The recording"} could not be loaded. Is the server still there?` } });
  }
}
