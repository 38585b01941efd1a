// Planners side by side.

/** Where planners look: among the true walls, on the map with the unknown taken to be free, or only where it was seen. */
export type Ground = "truth" | "map" | "known";

/** What all planners are asked. */
export interface ContestAsk {
  ground: Ground;
  /** x y of the start, of the goal, map frame, m. */
  ends: readonly [number, number, number, number];
  /** Time of each planner, s. */
  seconds: number;
}

/** Places of the numbers of each planner in `ContestState.standings`: flags are 0 or 1, m, s; NaN without a path. */
export const STANDING = { over: 0, straight: 1, length: 2, ratio: 3, seconds: 4, iterations: 5, tried: 6 } as const;
export const STANDING_STRIDE = 7;

/** How all planners stand; lists in the order of their names. */
export interface ContestState extends ContestAsk {
  running: boolean;
  planners: readonly string[];
  /** Width of the disc around the robot, m: what all but the planner `Outline` plan for. */
  disc: number;
  standings: Float64Array;
  /** Why there is no path: blocked, proved, not-offered or open, and in words; rooms, and why the planner left the rooms on the way; empty otherwise. */
  reasons: readonly { readonly kind: string; readonly text: string }[];
  /** What lengths are held against, m, and whether there is no shorter path; NaN while there is no path. */
  shortest: number;
  isOptimum: boolean;
  /** x y of the corners. */
  paths: readonly Float32Array[];
  /** Time taken, s, and length, m, whenever that became shorter. */
  curves: readonly Float64Array[];
  /** Whose tree this is, x1 y1 x2 y2. */
  watched: number;
  tree: Float32Array;
}
