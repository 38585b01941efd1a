// What a click on free floor means: the robot goes there only if the present mode allows it.

import type { Store } from "./store.js";

/** How long the question stands, wall milliseconds. */
const ASKED_MILLIS = 12_000;
const TOPIC = "errand";

/** Whether a click on the map sends the robot there, or a question comes first: a goal would end an
    exploration, so that is not done without asking. During the tour's exploration a click does
    nothing. */
export function clickSends({ source, status, setup, bridge, aiming, tour }: Store): "goes" | "asks" | "stays" {
  if (source === "replay" || (source === "bridge" && !bridge?.armed)) return "stays";
  if (aiming || (status?.mode ?? setup.mode) !== "explore") return "goes";
  return tour ? "stays" : "asks";
}

/** Sends the robot by `go`, or asks whether to. Enter, in place of a click, answers a question that
    stands. */
export function sendByClick(store: Store, go: () => void, isByKey: boolean): void {
  const meaning = clickSends(store);
  if (meaning === "goes") go();
  if (meaning !== "asks") return;
  const asked = store.toast?.topic === TOPIC ? store.toast : null;
  store.set("toast", { toast: isByKey && asked ? null : { level: "info", text: "Send the robot there?", topic: TOPIC, way: { label: "Go there", go }, stands: ASKED_MILLIS } });
  if (isByKey) asked?.way?.go();
}
