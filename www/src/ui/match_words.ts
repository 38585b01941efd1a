// The outcome for a line of a scan, in words.

import type { Decision } from "../protocol/module.js";
import { word } from "../spoken.js";

export const DECISION_WORDS: Readonly<Record<Decision, string>> = {
  matched: word("recognised"),
  added: "a new wall",
  ambiguous: "dropped: two walls explain it nearly as well",
  "outside-gate": "dropped: too far for a match, too near for a new wall",
  taken: "dropped: its wall was already seen in this scan",
  "on-a-wall": "dropped: it lies on a wall that the scan shows too",
  seam: "dropped: it lies across the seam of the sweep",
  singular: "dropped: its innovation has no proper covariance",
};
