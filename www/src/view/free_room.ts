// What of the map is left free by what lies over it: what is fitted goes there.

import { current as currentLesson } from "../lessons.js";
import { isNarrow } from "../screen.js";
import type { Store } from "../store.js";
import type { Camera } from "./camera.js";

/** CSS pixels of free height from which on a phone has room for the scale. */
const LEAST_SCALED = 140;
/** CSS pixels of width from which on a story has room beside the map. */
const LEAST_BESIDE = 960;
/** CSS pixels of height of a name alone, which leaves the map its room. */
const LEAST_TOLD = 130;
/** What the buttons at its right take of a phone's map, CSS pixels. */
const TOOLS = 58;
/** What the line of a run's past takes of the lower end, CSS pixels. */
const TIME_LINE = 50;

/** The panels that a phone shows as a sheet over the map. */
const PANELS = { run: "#run-panel", status: "#status-panel", plots: "#plots-panel", filter: "#filter-panel", paths: "#paths-panel", settings: "#settings-panel", layers: "#legend", log: "#log-panel" } as const;

export interface FreeRoom {
  /** What is covered at each side, CSS pixels. */
  readonly inset: Camera["inset"];
  /** Height of the card that tells something, CSS pixels; 0 without one. */
  readonly card: number;
  /** A long sheet leaves a strip, with room for the robot only. */
  readonly isLow: boolean;
}

export function freeRoom(map: HTMLElement, store: Store): FreeRoom {
  const phone = isNarrow();
  const bounds = map.getBoundingClientRect();
  const boxOf = (selector: string): DOMRect | undefined => document.querySelector(selector)?.getBoundingClientRect();
  const dock = parseFloat(getComputedStyle(map).getPropertyValue("--dock")) || 0;
  // An open sheet covers the lower part of the map.
  const sheet = phone && store.tab !== "" ? boxOf(PANELS[store.tab]) : undefined;
  const covered = sheet && sheet.height > 0 ? bounds.bottom - sheet.top : dock;
  // What is told covers the upper part of a phone, and stands beside the map where there is room
  // for both.
  const isTold = store.tour !== null || store.exhibit !== null || currentLesson(store) !== null || store.lastRun !== null;
  const inspector = boxOf("#inspector");
  const story = isTold ? (boxOf("#tour")?.height ?? 0) : 0;
  const card = Math.max(inspector?.height ?? 0, story);
  const offered = boxOf("#tip")?.height ?? 0;
  return { inset: inset(), card, isLow: map.clientHeight - covered < LEAST_SCALED };

  function inset(): Camera["inset"] {
    // Runs side by side have their names above, and nothing over them else.
    if (document.body.hasAttribute("data-race")) return { top: 44, right: phone ? 12 : 62, bottom: 12, left: 12 };
    if (phone) return { top: card + 20, right: store.tour ? 12 : TOOLS, bottom: covered + 12 + (sheet ? 0 : offered), left: 12 };
    const told = story > LEAST_TOLD && map.clientWidth >= LEAST_BESIDE ? 372 : 0;
    // During the tour there is no legend.
    const legend = matchMedia("(min-width: 1180px)").matches && !store.tour ? 238 : 14;
    return {
      top: 24,
      right: 62 + told,
      bottom: (store.inCycle ? 206 : 92) + (store.source === "bridge" ? 0 : TIME_LINE) + (offered > 0 ? offered + 12 : 0),
      left: inspector && inspector.width > 0 ? inspector.right - bounds.left + 12 : legend,
    };
  }
}
