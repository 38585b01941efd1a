// The wording for a place where the map is torn, shared by all views.

import type { Tear, TearName } from "../protocol/module.js";
import { word } from "../spoken.js";
import { t } from "../words.js";
import { clock, fixed } from "./format.js";

/** The reason, as the end of a sentence. */
export const WHY: Readonly<Record<TearName, string>> = {
  doubled: "the same walls stand twice",
  contradicted: "walls stand where nothing was at the other time",
  loose: "the robot was lost in between",
  unproven: "the way between was long, and nothing else proves it",
};

export const seen = ([from, to]: readonly [number, number]): string => t`${clock(from)} to ${clock(to)}`;

/** How far apart the sides are, in words; empty if unknown. */
export const apart = ({ off }: Tear): string => off === null ? "" : t`${fixed(off, 1)} m off`;

/** The name of the place: if nothing proves it, nothing is contradicted either. */
export const called = ({ kind }: Tear): string => kind === "unproven" ? word("doubtful") : word("torn");

/** The text for a mark under the pointer. */
export function tearWords(tear: Tear): string {
  const off = apart(tear);
  return `${t(called(tear))}: ${t(WHY[tear.kind])}${off === "" ? "" : `, ${off}`}`;
}
