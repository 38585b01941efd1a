// One sentence on what is happening.

import type { Status } from "../protocol/frame.js";
import { isTouched } from "../screen.js";
import type { Store } from "../store.js";
import { t } from "../words.js";
import { worldTitle } from "../worlds.js";
import { clock, length, percent, sentence } from "./format.js";

export interface Caption {
  doing: string;
  more: string;
}

/** A robot this far from its pose in the map has lost its way, m. */
const ASTRAY = 0.5;
/** A run this far behind its furthest time, s, is repeating itself. */
const PAST = 0.5;

const AIMING: Caption = { doing: "Click the map where the robot should go", more: "" };

export function caption(store: Store): Caption {
  const { status, playing, source, title, reading, loading } = store;
  if (reading) return { doing: t`Reading ${reading.name}`, more: percent(reading.done) };
  if (loading) return { doing: t`Loading ${t(worldTitle(loading))}…`, more: "" };
  if (!status && store.bridge?.fault) return { doing: "No connection to the bridge", more: store.bridge.fault };
  if (!status) return { doing: "Starting…", more: "" };
  const doubt = doubtOf(status);
  if (source === "replay") {
    if (status.finished && status.progress < 1) return { doing: t`Mapped a part of ${title}`, more: t`${status.reason} at ${percent(status.progress)}` };
    if (status.finished) return { doing: t`Mapped ${title}`, more: worthOf(store) || status.reason };
    const left = Number.isFinite(status.remaining) ? t`${clock(status.remaining)} left` : "";
    if (doubt && playing) return { doing: doubt, more: [t`in ${title}`, percent(status.progress)].join(", ") };
    return { doing: playing ? t`Mapping ${title}` : t`Paused in ${title}`, more: [percent(status.progress), left].filter(Boolean).join(", ") };
  }
  if (source === "bridge") {
    const bridge = store.bridge;
    if (bridge?.connection !== "open") return { doing: bridge?.connection === "connecting" ? t`Connecting to ${title}` : t`No connection to ${title}`, more: bridge?.fault ?? "" };
    if (bridge.emergency) return { doing: "Emergency stop", more: "the motors are cut off" };
    if (store.aiming) return AIMING;
    if (bridge.armed && status.finished) return { doing: sentence(status.reason) || "Finished", more: "" };
    if (doubt) return { doing: doubt, more: bridge.armed ? status.activity || byHand() : "" };
    if (bridge.armed) return { doing: { explore: "Exploring", goto: "Driving to the goal", manual: "You drive" }[status.mode], more: status.activity || byHand() };
    return { doing: bridge.driver ? t`${bridge.driver} drives` : t`Watching ${title}`, more: "" };
  }
  const off = store.tour || !(status.positionError > ASTRAY) ? "" : offBy(status.positionError);
  if (status.finished) return { doing: sentence(status.reason) || "Finished", more: told(worthOf(store), off) };
  // Only the simulation knows how much there is to be known. The tour is about the robot.
  const known = Number.isFinite(status.explored) && !store.tour ? t`${percent(status.explored)} explored` : "";
  if (store.aiming) return AIMING;
  if (store.isStopped && status.mode === "manual") return { doing: "Stopped", more: told(known, isTouched() ? "tap the map, explore again, or drive" : "click the map, explore again, or drive") };
  if (doubt && playing) return { doing: doubt, more: known };
  if (store.seeking === null && store.furthest > status.time + PAST) {
    const [now, all] = [clock(status.time), clock(store.furthest)];
    return { doing: playing ? t`The same way again: ${now} of ${all}` : t`Back at ${now} of ${all}`, more: "whatever you do now, the run goes another way from here" };
  }
  const doing = { explore: "Exploring", goto: "Driving to the goal", manual: "You drive" }[status.mode];
  const hint = status.mode === "manual" ? byHand() : "";
  if (doubt) return { doing: t`Paused · ${t(doubt).toLowerCase()}`, more: known };
  return { doing: playing ? doing : t`Paused · ${t(doing).toLowerCase()}`, more: told(known, off, status.activity || hint) };
}

/** A simulated robot's true error, which its map cannot tell. */
function offBy(metres: number): string {
  const { value, unit } = length(metres);
  return t`${value} ${unit} off the truth`;
}

/** A warning that the pose is unreliable, which precedes what it is doing; empty if it is
    reliable. */
function doubtOf({ localisation, placed }: Status): string {
  if (localisation === "lost") return "Lost: it searches the map for where it is, and what it draws meanwhile is faint";
  if (localisation === "ambiguous") return "Not sure where it is: what it draws meanwhile is faint";
  return placed ? "" : "Maps a piece of its own: its place in the saved map is not proved yet";
}

/** Joins those parts that are not empty. */
const told = (...parts: readonly string[]): string => parts.filter((part) => part !== "").map((part) => t(part)).join(" · ");

/** The judgement of the map of a finished run, as far as it has come; empty if nobody asked. */
function worthOf({ quality, judging }: Store): string {
  if (judging !== null) return t`judging the map, ${percent(judging)}`;
  if (!quality) return "";
  if (quality.unjudgeable && quality.tears.length === 0) return "nothing can be said of the map";
  const count = quality.tears.length;
  const places = count === 1 ? "one place" : t`${count} places`;
  const good = quality.agreement === null ? "no place was seen twice" : "the map agrees with itself";
  return { good, doubtful: t`the map is doubtful at ${places}`, torn: t`the map is torn at ${places}` }[quality.verdict];
}

/** How to steer: touch screens have no keys. */
function byHand(): string {
  return isTouched() ? "by the stick" : "arrow keys, WASD or the stick";
}
