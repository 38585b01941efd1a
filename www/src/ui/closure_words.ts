// Why a placement of one submap in another was accepted or not, in words.

import type { CLOSURE, ClosureOutcome } from "../protocol/module.js";
import { t } from "../words.js";
import { CHI2_95 } from "./chi2.js";
import { fixed } from "./format.js";

export type Figures = Readonly<Record<keyof typeof CLOSURE, number>>;

const submaps = (count: number): string => `${fixed(count, 1)} ${fixed(count, 1) === "1.0" ? "submap" : "submaps"}`;

/** The reason, in a sentence or two. Evidence counts submaps that lie wholly on one another. */
export const WHY: Readonly<Record<ClosureOutcome, (f: Figures) => string>> = {
  "known-before": () => "No search was needed: the place was known well enough to match the two at once, and it fits.",
  proved: (f) => t`It was searched for, and proved: this place and those that agree with it are worth ${submaps(f.evidence)}, where ${fixed(f.asked, 1)} were asked for${f.rival > 0 ? t`; the best rival has ${fixed(f.rival, 1)}` : ", and nothing contradicts it"}.`,
  "not-judged": () => "It was found just now and is not judged yet.",
  "too-little-proof": (f) => t`Too little proof so far: this place and those that agree with it are worth ${submaps(f.evidence)}, and ${fixed(f.asked, 1)} are asked for. So wide a search finds something that fits by chance.`,
  "beyond-belief": () => "It is farther from where the way leads than all that is feared of the way: what fits there is another place that looks alike, however much of it fits.",
  tears: (f) => t`It is proved well enough, ${submaps(f.evidence)}, but believed it would tear the way between submaps that follow each other. Either it is false, or others are: what comes next decides.`,
  overruled: (f) => t`It is proved well enough, ${submaps(f.evidence)}, but the way and other closures hold the map elsewhere: believed, it would bend nothing. What comes next decides.`,
  rivals: (f) => t`The building looks alike here: this place is worth ${submaps(f.evidence)}, and one that contradicts it ${fixed(f.rival, 1)}. What comes next decides.`,
  "placed-elsewhere": (f) => t`When it was judged, others placed this submap with more proof, and this place did not go with theirs.${f.chi2 <= CHI2_95 ? " The map was bent since: as it lies now, they do not differ." : ""}`,
  revoked: () => "It was accepted, but with it the way from one submap to the next was torn apart, and without it less is left unexplained: it was taken out again.",
  "never-proved": () => "It waited for proof until newer places took its room.",
};
