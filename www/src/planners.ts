// What a person calls the planners.

import type { PlannerName } from "./protocol/module.js";

/** As a part of a sentence. */
const TITLES: Readonly<Record<PlannerName, string>> = {
  straight: "a straight line", rrt: "RRT", "rrt-connect": "RRT-Connect", "rrt-star": "RRT*", "informed-rrt-star": "Informed RRT*",
  "a-star": "A*", "theta-star": "Theta*", rooms: "rooms, then Theta*", visibility: "the visibility graph", outline: "the outline's turns and steps", wavefront: "a wave over the grid",
};

/** Where a list wants another word than a sentence. */
const LABELS: Readonly<Partial<Record<PlannerName, string>>> = { visibility: "Visibility", outline: "Outline" };

export function plannerTitle(name: PlannerName): string {
  return TITLES[name];
}

/** As an entry of a list. */
export function plannerLabel(name: PlannerName): string {
  return LABELS[name] ?? TITLES[name];
}
