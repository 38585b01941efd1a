// The titles of the built-in worlds, wherever one is named to people.

const TITLES: Readonly<Record<string, string>> = {
  office: "Office: rooms off a corridor",
  arena: "Arena: walls and boxes",
  doors: "Doors: rooms and narrow gaps",
  corridor: "Corridor: 30 m, hardly a feature",
  loop: "Loop: a long ring",
  maze: "Maze: passages all alike",
  lab: "Lab: glass and dark walls",
  crowd: "Crowd: ten people walk about",
  warehouse: "Warehouse: racks and aisles, 40 m",
  "look-alikes": "Look-alikes: ten equal rooms",
  parallel: "Parallel: four equal corridors",
  campus: "Campus: 120 houses, for speed",
};

/** A world without a title here is called by its name. */
export const worldTitle = (name: string): string => (Object.hasOwn(TITLES, name) ? TITLES[name] : undefined) ?? name;

/** The title of a run's world: somebody's own world keeps the name that they gave it. */
export const titleOf = ({ world, worldJson }: { readonly world: string; readonly worldJson: unknown }): string =>
  worldJson === null ? worldTitle(world) : world;
