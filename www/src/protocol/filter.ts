// What goes on inside the line filter.

/** What the filter's figures say; the meaning stands with `Diagnosis` in the core. */
export type DiagnosisName = "collecting" | "blind" | "honest" | "wrong-match" | "hidden-drift" | "noisy-sightings" | "cautious";

/** What became of a line of the scan, in the order of their codes. */
export const VERDICTS = ["matched", "added", "ambiguous", "outside-gate", "taken", "seam", "singular"] as const;

/** Inside which gate a candidate lies, in the order of their codes. */
export const GATES = ["match", "near", "far", "beyond"] as const;

/** Places of the numbers of each line in `Inspection.sightings`; ends in the map frame, m. */
export const SIGHTING = { x1: 0, y1: 1, x2: 2, y2: 3, verdict: 4, landmark: 5, candidates: 6 } as const;
export const SIGHTING_STRIDE = 7;

/** Places of the numbers of each candidate in `Inspection.candidates`; rad and m. */
export const CANDIDATE = { landmark: 0, d2: 1, gap: 2, deltaAlpha: 3, deltaR: 4, sigmaAlpha: 5, sigmaR: 6, gate: 7 } as const;
export const CANDIDATE_STRIDE = 8;

/** Places of what is learned of the odometry: turn in a drive that it takes for straight, rad/m; part by which a turn is larger than
 * it says; and their standard deviations. */
export const ODOMETRY = { curvature: 0, turnScale: 1, curvatureSigma: 2, turnScaleSigma: 3 } as const;

/** The line filter after the last scan. */
export interface Inspection {
  /** Rows of the matrix that belong to the robot; two for each landmark follow, α and r. */
  robotRows: number;
  /** Landmarks in the order of their rows. */
  landmarks: Uint32Array;
  /** Correlation coefficients, row by row, -1 to 1; empty where the matrix was not asked for. */
  coefficients: Float32Array;
  /** Lines of the scan, see SIGHTING. */
  sightings: Float64Array;
  /** What they were compared with, in the same order, see CANDIDATE. */
  candidates: Float64Array;
  /** What the filter learned of its odometry, see ODOMETRY. */
  odometry: Float64Array;
  /** Largest d² of a match, and smallest of a new wall. */
  gate: number;
  newGate: number;
  /** Largest free distance between the seen and the known part of one wall, m. */
  maxGap: number;
}
