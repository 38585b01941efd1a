// Reads the matrix of an inspection: its rows, and which of them belong to a wall or a point.

import type { Inspection } from "./protocol/module.js";
import { t } from "./words.js";

/** A row of the matrix: a state variable of the robot, of a wall, or of a point. */
export interface Row {
  wall: number | null;
  symbol: string;
  /** To whom the variable belongs, in words. */
  owner: string;
}

/** The robot's rows: its pose, then the systematic errors of its odometry. */
const ROBOT_ROWS: readonly Row[] = [
  ...["x", "y", "θ"].map((symbol) => ({ wall: null, symbol, owner: "the robot" })),
  { wall: null, symbol: "curvature", owner: "the odometry" },
  { wall: null, symbol: "turn scale", owner: "the odometry" },
];

export function rowOf(inspection: Inspection, index: number): Row {
  const { robotRows, landmarks, points } = inspection;
  if (index < robotRows) return ROBOT_ROWS[index] ?? { wall: null, symbol: t`state ${index + 1}`, owner: "the robot" };
  const at = index - robotRows;
  const wall = landmarks[Math.floor(at / 2)] ?? null;
  if (wall !== null && points.includes(wall)) return { wall: null, symbol: at % 2 === 0 ? "x" : "y", owner: t`point ${wall}` };
  return { wall, symbol: at % 2 === 0 ? "α" : "r", owner: t`wall ${wall}` };
}

/** The first of the two rows of a wall; null if it is not in the matrix. */
export function firstRowOf(inspection: Inspection, wall: number): number | null {
  const at = inspection.landmarks.indexOf(wall);
  return at < 0 ? null : inspection.robotRows + 2 * at;
}

export function sizeOf(inspection: Inspection): number {
  return inspection.robotRows + 2 * inspection.landmarks.length;
}
