// The part of the map that is not covered by other elements: the view is fitted into it.

import { current as currentLesson } from "../lessons.js";
import { isNarrow } from "../screen.js";
import type { Store } from "../store.js";
import type { Camera } from "./camera.js";

/** A phone's map shows the scale from this free height on, CSS pixels. */
const LEAST_SCALED = 140;
/** A story stands beside the map from this width on, CSS pixels. */
const LEAST_BESIDE = 960;
/** A card up to this height shows a name alone, and leaves the map its room, CSS pixels. */
const LEAST_TOLD = 130;
/** Width of the buttons at the right of a phone's map, CSS pixels. */
const TOOLS = 58;
/** Height of the time line at the lower end, CSS pixels. */
const TIME_LINE = 50;

/** The panels that a phone shows as a sheet over the map. */
const PANELS = { run: "#run-panel", status: "#status-panel", plots: "#plots-panel", filter: "#filter-panel", paths: "#paths-panel", settings: "#settings-panel", layers: "#legend", log: "#log-panel" } as const;

export interface FreeRoom {
  /** Covered width at each side, CSS pixels. */
  readonly inset: Camera["inset"];
  /** Height of the card over the map, CSS pixels; 0 without one. */
  readonly card: number;
  /** Height of what is offered over its lower end, with its margin, CSS pixels; 0 without an
      offer. */
  readonly offer: number;
  /** A long sheet leaves only a strip, with room for the robot. */
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
  // A story covers the upper part of a phone's map, and stands beside the map where there is room
  // for both.
  const isTold = store.tour !== null || store.exhibit !== null || currentLesson(store) !== null || store.lastRun !== null;
  const inspector = boxOf("#inspector");
  const story = isTold ? (boxOf("#tour")?.height ?? 0) : 0;
  const card = Math.max(inspector?.height ?? 0, story);
  const offered = boxOf("#tip")?.height ?? 0;
  const offer = offered > 0 ? offered + 12 : 0;
  return { inset: inset(), card, offer, isLow: map.clientHeight - covered < LEAST_SCALED };

  function inset(): Camera["inset"] {
    // Runs side by side have their names above, and nothing else over them.
    if (document.body.hasAttribute("data-race")) return { top: 44, right: phone ? 12 : 62, bottom: 12, left: 12 };
    if (phone) return { top: card + 20, right: store.tour ? 12 : TOOLS, bottom: covered + 12 + (sheet ? 0 : offered), left: 12 };
    const told = story > LEAST_TOLD && map.clientWidth >= LEAST_BESIDE ? 372 : 0;
    // The tour hides the legend.
    const legend = matchMedia("(min-width: 1180px)").matches && !store.tour ? 238 : 14;
    return {
      top: 24,
      right: 62 + told,
      bottom: (store.inCycle ? 206 : 92) + (store.source === "bridge" ? 0 : TIME_LINE) + offer,
      left: inspector && inspector.width > 0 ? inspector.right - bounds.left + 12 : legend,
    };
  }
}
