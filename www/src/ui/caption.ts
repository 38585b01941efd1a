// One sentence on what is happening.

import type { Status } from "../protocol/frame.js";
import type { Store } from "../store.js";
import { clock, percent, sentence } from "./format.js";

export interface Caption {
  doing: string;
  more: string;
}

const AIMING: Caption = { doing: "Click the map where the robot should go", more: "" };

export function caption(store: Store): Caption {
  const { status, playing, source, title, reading, loading } = store;
  if (reading) return { doing: `Reading ${reading.name}`, more: percent(reading.done) };
  if (loading) return { doing: `Loading ${loading}…`, more: "" };
  if (!status && store.bridge?.fault) return { doing: "No connection to the bridge", more: store.bridge.fault };
  if (!status) return { doing: "Starting…", more: "" };
  const doubt = doubtOf(status);
  if (source === "replay") {
    if (status.finished && status.progress < 1) return { doing: `Mapped a part of ${title}`, more: [status.reason, percent(status.progress)].join(" at ") };
    if (status.finished) return { doing: `Mapped ${title}`, more: worthOf(store) || status.reason };
    const left = Number.isFinite(status.remaining) ? `${clock(status.remaining)} left` : "";
    if (doubt && playing) return { doing: doubt, more: [`in ${title}`, percent(status.progress)].join(", ") };
    return { doing: `${playing ? "Mapping" : "Paused in"} ${title}`, more: [percent(status.progress), left].filter(Boolean).join(", ") };
  }
  if (source === "bridge") {
    const bridge = store.bridge;
    if (bridge?.connection !== "open") return { doing: bridge?.connection === "connecting" ? `Connecting to ${title}` : `No connection to ${title}`, more: bridge?.fault ?? "" };
    if (bridge.emergency) return { doing: "Emergency stop", more: "the motors are cut off" };
    if (store.aiming) return AIMING;
    if (bridge.armed && status.finished) return { doing: sentence(status.reason) || "Finished", more: "" };
    if (doubt) return { doing: doubt, more: bridge.armed ? status.activity || byHand() : "" };
    if (bridge.armed) return { doing: { explore: "Exploring", goto: "Driving to the goal", manual: "You drive" }[status.mode], more: status.activity || byHand() };
    return { doing: bridge.driver ? `${bridge.driver} drives` : `Watching ${title}`, more: "" };
  }
  const known = Number.isFinite(status.explored) ? `${percent(status.explored)} known` : "";
  if (status.finished) return { doing: sentence(status.reason) || "Finished", more: [worthOf(store), known].filter(Boolean).join(" · ") };
  if (store.aiming) return AIMING;
  if (store.isStopped && status.mode === "manual") return { doing: "Stopped", more: [known, `${matchMedia("(pointer: coarse)").matches ? "tap" : "click"} the map, explore again, or drive`].filter(Boolean).join(" · ") };
  if (doubt && playing) return { doing: doubt, more: known };
  const doing = { explore: "Exploring", goto: "Driving to the goal", manual: "You drive" }[status.mode];
  const hint = status.mode === "manual" ? byHand() : "";
  return { doing: playing ? doing : `Paused · ${doing.toLowerCase()}`, more: [known, status.activity || hint].filter(Boolean).join(" · ") };
}

/** That its pose is not to be believed, which goes before what it is doing; empty where it is. */
function doubtOf({ localisation, placed }: Status): string {
  if (localisation === "lost") return "Lost: it searches the map for where it is";
  if (localisation === "ambiguous") return "Not sure where it is";
  return placed ? "" : "Maps a piece of its own: its place in the saved map is not proved yet";
}

/** What the map of a finished run is worth, as far as it was judged; empty where nobody asked. */
function worthOf({ quality, judging }: Store): string {
  if (judging !== null) return `judging the map, ${percent(judging)}`;
  if (!quality) return "";
  if (quality.unjudgeable && quality.tears.length === 0) return "nothing can be said of the map";
  const count = quality.tears.length;
  const places = count === 1 ? "one place" : `${count} places`;
  const good = quality.agreement === null ? "no place was seen twice" : "the map agrees with itself";
  return { good, doubtful: `the map is doubtful at ${places}`, torn: `the map is torn at ${places}` }[quality.verdict];
}

/** What steers: a thumb has no keys. */
function byHand(): string {
  return matchMedia("(pointer: coarse)").matches ? "by the stick" : "arrow keys, WASD or the stick";
}
