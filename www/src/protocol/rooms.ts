// The topological map.

/** Places of the numbers of each region in `Rooms.regions`: kind 0 for a room and 1 for a corridor, m² and m. */
export const REGION = { kind: 0, area: 1, x: 2, y: 3, width: 4 } as const;
export const REGION_STRIDE = 5;

/** Places of the numbers of each door in `Rooms.doors`: the regions it joins, posts, middle and width in m, and whether both posts were seen. */
export const DOORWAY = { from: 0, to: 1, x1: 2, y1: 3, x2: 4, y2: 5, x: 6, y: 7, width: 8, framed: 9 } as const;
export const DOORWAY_STRIDE = 10;

/** The topological map: rooms, corridors and doors, the largest region first; map frame, m. */
export interface Rooms {
  regions: Float64Array;
  doors: Float64Array;
  /** x y of the corners of all outlines. */
  corners: Float32Array;
  /** Of each outline its region and number of corners. */
  rings: Uint32Array;
}
