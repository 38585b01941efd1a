// The recording that comes with the page, for visitors who have none of their own. It is loaded on
// demand (www/examples/make.mjs shows how it was made).

import type { Client } from "./client.js";
import type { Recording } from "./files.js";
import { word } from "./spoken.js";
import type { Store } from "./store.js";
import { t } from "./words.js";

const FILE = "examples/ring.gzip";
/** The name of the log in it. */
export const EXAMPLE = "ring.log";

const SPEED = 20;
const WATCH = word("A drive all round a ring, as a lidar and wheels logged it. Without a truth nobody knows the error: watch how far the way is off where it comes round, and how the map gives way there.");
/** How long the hint on what to watch stays, wall milliseconds. */
const WATCH_MILLIS = 15_000;

const examples = new WeakSet<File>();

export async function openExample(store: Store, client: Client): Promise<void> {
  try {
    const answer = await fetch(new URL(FILE, import.meta.url));
    if (!answer.ok) throw new Error(answer.statusText);
    const file = new File([await answer.blob()], EXAMPLE);
    examples.add(file);
    await client.files.openAll([file]);
  } catch {
    store.set("toast", { toast: { level: "warn", text: t`${"The recording"} could not be loaded. Is the server still there?` } });
  }
}

export const isExample = (recording: Recording | null): boolean => recording !== null && examples.has(recording.file);

/** Slow enough to be watched, with the layers that show something. */
export function presentExample(store: Store, client: Client): void {
  client.setSpeed(SPEED);
  store.set("toast", { toast: { level: "info", text: WATCH, stands: WATCH_MILLIS } });
}
