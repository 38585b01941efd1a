// Constraints of the pose graph: a loop closure, with the reason why it was accepted or not, and
// the join of two consecutive submaps.

import { degrees } from "../angle.js";
import { CLOSURE, CLOSURE_STRIDE, type SUBMAP } from "../protocol/module.js";
import { equals, formula, id, op, row, sub, sup } from "../registration/formula.js";
import { chi2Meaning, chi2Words } from "../ui/chi2.js";
import { type Figures, WHY } from "../ui/closure_words.js";
import { fixed, percent } from "../ui/format.js";
import { type ClosureName, rowOf } from "../view/layers/closures.js";
import type { Fate } from "../view/submaps.js";
import { t } from "../words.js";
import { type Formula, GONE, type Known, type Told } from "./told.js";
import { matrix, metres, number } from "./words.js";

const FATES: Readonly<Record<Fate, string>> = { accepted: "Accepted", neighbour: "Accepted", waiting: "Waits", refused: "Refused", revoked: "Revoked" };
const MATCHED = "Scans of the one are also in the other: the motion between the two was measured by matching.";
const NEIGHBOUR = "It closes no loop: the robot had not been away in between, so the two are neighbours on its way.";
const LOOSE = "The scan that began the later one did not belong to the one before: the motion between the two is known by odometry or speed alone.";

const shift = (metre: number, radian: number): string => `${metres(metre)}, ${fixed(degrees(radian), 1)}°`;

export function closure(name: ClosureName, { scene: { submaps } }: Known): Told {
  const found = rowOf(submaps, name);
  const [outcome, fate] = found === null ? [] : [submaps.outcomes[found], submaps.fates[found]];
  const title = t`Submap ${name[1]} in submap ${name[0]}`;
  if (found === null || !outcome || !fate) return { title, words: GONE, figures: [], outline: [] };
  const f = Object.fromEntries(Object.entries(CLOSURE).map(([each, place]) => [each, submaps.closures[found * CLOSURE_STRIDE + place] ?? NaN])) as unknown as Figures;
  return {
    title,
    fate: FATES[fate],
    words: fate === "neighbour" ? `${t(WHY[outcome](f))} ${t(NEIGHBOUR)}` : WHY[outcome](f),
    figures: [
      ["Off by now", shift(Math.hypot(f.offX, f.offY), Math.abs(f.offTurn)), "closure-off", "Between the place that was found and where the two submaps lie now"],
      ["Residual χ²", chi2Words(f.chi2), "closure-chi2", chi2Meaning],
      ["Known before to", `±${shift(f.doubtShift, f.doubtTurn)}`, "closure-doubt", "Standard deviation of the place before the two were compared"],
      ["Overlap", percent(f.overlap), "closure-overlap", "How much of the smaller submap lies on the other"],
      ["Agrees", percent(f.part), "closure-part", "Of what both could see, the part that is the same"],
    ],
    formulas: [residual((name) => f[name])],
    // Its layer draws it, with the place where the new one would lie.
    outline: [],
  };
}

/** A join, given by its later submap. */
export function join(later: number, { scene: { submaps } }: Known): Told {
  const title = t`Submap ${later - 1} to submap ${later}`;
  if (later >= submaps.count) return { title, words: GONE, figures: [], outline: [] };
  const isLoose = submaps.isLoose(later);
  const at = (name: Parameters<typeof submaps.figure>[1]): number => submaps.figure(later, name);
  const told = { title, fate: isLoose ? "Loose" : "Matched", words: isLoose ? LOOSE : MATCHED, outline: [] };
  if (Number.isNaN(at("chi2"))) return { ...told, words: t`${told.words} No motion was measured between them: a part of the way is missing.`, figures: [] };
  return {
    ...told,
    figures: [
      ["Off by now", shift(Math.hypot(at("offX"), at("offY")), Math.abs(at("offTurn"))), "join-off", "Between where the motion that was measured has the later submap and where it lies now: loop closures bend the way"],
      ["Residual χ²", chi2Words(at("chi2")), "join-chi2", chi2Meaning],
      ["Known to", `±${shift(at("joinShift"), at("joinTurn"))}`, "join-known", "Standard deviation of the motion that was measured"],
    ],
    formulas: [residual(at)],
  };
}

/** The parts of a constraint's residual that both kinds have. */
type Part = keyof typeof CLOSURE & keyof typeof SUBMAP;

function residual(at: (name: Part) => number): Formula {
  const e = [at("offX"), at("offY"), at("offTurn")];
  const [xx, xy, xt, yy, yt, tt] = [at("infoXx"), at("infoXy"), at("infoXt"), at("infoYy"), at("infoYt"), at("infoTt")];
  const omega = [[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]];
  const x = (index: string): Element => sup(sub(id("x"), id(index)), "−1");
  return {
    general: formula(row(sup(id("χ"), "2"), equals(), sup(id("e"), "T"), id("Ω"), id("e"), op(","), id("e"), equals(), sup(id("z"), "−1"), x("i"), sub(id("x"), id("j")))),
    numbers: [
      formula(row(id("e"), equals(), matrix(e.map((each) => [each])), op(","), id("Ω"), equals(), matrix(omega))),
      formula(row(sup(id("χ"), "2"), equals(), sup(id("e"), "T"), id("Ω"), id("e"), equals(), number(at("chi2")))),
    ],
    source: "Kümmerle et al. 2011, edge of two poses: z the measured motion, e what the poses are off it (m, m, rad), Ω its information",
  };
}
