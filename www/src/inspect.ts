// Reads an inspection: rows of the matrix, walls by name, and what was compared with what.

import { CANDIDATE, CANDIDATE_STRIDE, type Gate, GATES, type Inspection, SIGHTING, SIGHTING_STRIDE, type Verdict, VERDICTS } from "./protocol/module.js";

export interface Candidate {
  wall: number;
  d2: number;
  gap: number;
  deltaAlpha: number;
  deltaR: number;
  sigmaAlpha: number;
  sigmaR: number;
  gate: Gate;
}

/** One line of the last scan. */
export interface Sighting {
  /** Its ends, map frame, m. */
  ends: readonly [number, number, number, number];
  verdict: Verdict;
  /** The wall it was recognised as, or became; null where it was not used. */
  wall: number | null;
  /** The likeliest first. */
  candidates: readonly Candidate[];
}

/** A row of the matrix: a number of the robot, or of a wall. */
export interface Row {
  wall: number | null;
  symbol: string;
  /** Whose number it is, in words. */
  owner: string;
}

/** The robot's rows: its pose, then what its odometry errs always. */
const ROBOT_ROWS: readonly Row[] = [
  ...["x", "y", "θ"].map((symbol) => ({ wall: null, symbol, owner: "the robot" })),
  { wall: null, symbol: "curvature", owner: "the odometry" },
  { wall: null, symbol: "turn scale", owner: "the odometry" },
];

export function rowOf(inspection: Inspection, index: number): Row {
  const { robotRows, landmarks } = inspection;
  if (index < robotRows) return ROBOT_ROWS[index] ?? { wall: null, symbol: `state ${index + 1}`, owner: "the robot" };
  const at = index - robotRows;
  const wall = landmarks[Math.floor(at / 2)] ?? null;
  return { wall, symbol: at % 2 === 0 ? "α" : "r", owner: `wall ${wall}` };
}

/** The first of the two rows of a wall; null where the matrix has none. */
export function firstRowOf(inspection: Inspection, wall: number): number | null {
  const at = inspection.landmarks.indexOf(wall);
  return at < 0 ? null : inspection.robotRows + 2 * at;
}

export function sizeOf(inspection: Inspection): number {
  return inspection.robotRows + 2 * inspection.landmarks.length;
}

export function sightingsOf({ sightings, candidates }: Inspection): Sighting[] {
  const found: Sighting[] = [];
  let first = 0;
  for (let i = 0; i + SIGHTING_STRIDE <= sightings.length; i += SIGHTING_STRIDE) {
    const at = (place: number): number => sightings[i + place] ?? NaN;
    const count = at(SIGHTING.candidates);
    found.push({
      ends: [at(SIGHTING.x1), at(SIGHTING.y1), at(SIGHTING.x2), at(SIGHTING.y2)],
      verdict: VERDICTS[at(SIGHTING.verdict)] ?? "singular",
      wall: Number.isFinite(at(SIGHTING.landmark)) ? at(SIGHTING.landmark) : null,
      candidates: Array.from({ length: count }, (_, k) => candidateOf(candidates, (first + k) * CANDIDATE_STRIDE)),
    });
    first += count;
  }
  return found;
}

function candidateOf(numbers: Float64Array, begin: number): Candidate {
  const at = (place: number): number => numbers[begin + place] ?? NaN;
  return {
    wall: at(CANDIDATE.landmark), d2: at(CANDIDATE.d2), gap: at(CANDIDATE.gap),
    deltaAlpha: at(CANDIDATE.deltaAlpha), deltaR: at(CANDIDATE.deltaR), sigmaAlpha: at(CANDIDATE.sigmaAlpha), sigmaR: at(CANDIDATE.sigmaR),
    gate: GATES[at(CANDIDATE.gate)] ?? "far",
  };
}
