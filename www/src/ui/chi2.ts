// The wording for the χ² of a constraint between two submaps, shared by all views.

import { t } from "../words.js";
import { fixed } from "./format.js";

/** χ² of 3 degrees of freedom is below this in 95 % of cases. */
export const CHI2_95 = 7.815;
/** Writes 1 116 908.5 as 1.1 million. */
const ROUGHLY = new Intl.NumberFormat("en", { notation: "compact", compactDisplay: "long", maximumSignificantDigits: 2 });

export const chi2Meaning = t`Of 3 degrees of freedom: below ${fixed(CHI2_95, 1)} in 95 of 100 cases, if its uncertainty is honest`;

export const chi2Words = (chi2: number): string =>
  `${chi2 < 1000 ? fixed(chi2, 1) : ROUGHLY.format(chi2)}${chi2 > CHI2_95 ? t`, expected under ${fixed(CHI2_95, 1)}` : ""}`;
