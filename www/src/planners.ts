// What a person calls the planners, by their names in the core.

const TITLES: Readonly<Record<string, string>> = {
  Straight: "a straight line", Rrt: "RRT", RrtConnect: "RRT-Connect", RrtStar: "RRT*", InformedRrtStar: "Informed RRT*",
  AStar: "A*", ThetaStar: "Theta*", Rooms: "rooms, then Theta*", Visibility: "the visibility graph", Outline: "the outline's turns and steps", Wavefront: "a wave over the grid",
};

/** Where a list wants another word than a sentence. */
const LABELS: Readonly<Record<string, string>> = { Visibility: "Visibility", Outline: "Outline" };

/** As a part of a sentence. */
export function plannerTitle(name: string): string {
  return TITLES[name] ?? name;
}

/** As an entry of a list. */
export function plannerLabel(name: string): string {
  return LABELS[name] ?? plannerTitle(name);
}
