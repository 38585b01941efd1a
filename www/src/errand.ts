// What a click on free floor means to the robot: it goes there only where that is what was chosen.

import type { Store } from "./store.js";

/** So long somebody may answer the question, wall milliseconds. */
const ASKED_MILLIS = 12_000;
const TOPIC = "errand";

/** Whether the robot goes where the map is clicked, or it is asked first: an exploration, which
    would end by that, is not given up unasked. The tour waits for the end of its own. */
export function clickSends({ source, status, setup, bridge, aiming, tour }: Store): "goes" | "asks" | "stays" {
  if (source === "replay" || (source === "bridge" && !bridge?.armed)) return "stays";
  if (aiming || (status?.mode ?? setup.mode) !== "explore") return "goes";
  return tour ? "stays" : "asks";
}

/** Sends the robot by `go`, or asks whether to; by Enter in place of a click the question that
    stands is answered. */
export function sendByClick(store: Store, go: () => void, isByKey: boolean): void {
  const meaning = clickSends(store);
  if (meaning === "goes") go();
  if (meaning !== "asks") return;
  const asked = store.toast?.topic === TOPIC ? store.toast : null;
  store.set("toast", { toast: isByKey && asked ? null : { level: "info", text: "Send the robot there?", topic: TOPIC, way: { label: "Go there", go }, stands: ASKED_MILLIS } });
  if (isByKey) asked?.way?.go();
}
