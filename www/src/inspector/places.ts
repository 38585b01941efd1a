// Places of the map: where it is torn, a frontier, a submap, a wall of the simulated world.

import { degrees } from "../angle.js";
import type { Tear, TearName } from "../protocol/module.js";
import { equals, fn, formula, id, op, row, sub } from "../registration/formula.js";
import { fixed, list } from "../ui/format.js";
import { chi2Words } from "../ui/chi2.js";
import { seen } from "../ui/tears.js";
import { t } from "../words.js";
import { cell } from "./cell.js";
import { ring, segment } from "./outlines.js";
import { GONE, type Known, type Told } from "./told.js";
import { angle, lineEquation, metres, number, place } from "./words.js";

const TORN: Readonly<Record<TearName, string>> = {
  doubled: "The same walls stand twice",
  contradicted: "Walls where nothing was before",
  loose: "The robot was lost in between",
  unproven: "Nothing proves the way between",
};

/** What it means, and what can be done about it. */
const MEANS: Readonly<Record<TearName, string>> = {
  doubled: "What was seen at one time would agree with what was seen at the other if it lay elsewhere: a loop that should join the two is missing, or a wrong one pulls them apart.",
  contradicted: "At one time the robot saw through what stands there by the other, and nothing nearby fits: the two parts may be different places, laid on one another.",
  loose: "The way between the two was not measured surely, and no loop holds them together: the later part lies about where it is drawn.",
  unproven: "The way between was measured, but it was long and no loop holds its ends together. This alone does not mean that anything is wrong.",
};

export function torn({ kind, place: [x, y], off, earlier, later, witnesses }: Tear): Told {
  return {
    title: TORN[kind],
    words: MEANS[kind],
    figures: [
      off === null
        ? ["Apart by", "too far to tell", "torn-off", "Nothing fits nearby"]
        : [kind === "doubled" ? "Walls apart by" : "Known to", `${kind === "doubled" ? "" : "±"}${metres(off)}`, "torn-off", "As measured between walls that stand twice, or one standard deviation of what is not known"],
      ["Seen first", seen(earlier), "torn-earlier", "Time of the run in which the one side was seen"],
      ["Seen again", seen(later), "torn-later", "Time of the run in which the other side was seen"],
      ["Where", `${list(fixed(x, 1), fixed(y, 1))} m`, "torn-where", "In the map"],
      ...(witnesses > 0 ? [["Pairs of submaps that say so", `${witnesses}`, "torn-witnesses", "One alone may be furniture that was moved; it is heard only where scans that two submaps share were shifted"] as const] : []),
    ],
    outline: [],
  };
}

export function frontier(x: number, y: number, known: Known): Told {
  const { status } = known.scene;
  const of = cell(x, y, known);
  return {
    ...of,
    title: "Frontier",
    fate: "",
    words: "A cell that is known to be free, beside one of which nothing is known: there is more to see from here. An explorer goes to the best of these, by what lies behind it and the way there.",
    figures: [...(status ? [["From the robot", metres(Math.hypot(status.x - x, status.y - y)), "frontier-away", "In a straight line"] as const] : []), ...of.figures],
    formulas: [{
      general: formula(row(sub(id("p"), fn("cell")), op("<"), number(0.35), op(","), sub(id("l"), fn("beside")), equals(), id("0"))),
      numbers: of.formulas?.[0]?.numbers ?? formula(row()),
      source: "Yamauchi 1997: a frontier is where what is known to be free meets the unknown",
    }],
  };
}

export function submap(index: number, { scene: { submaps } }: Known): Told {
  const title = t`Submap ${index}`;
  if (index >= submaps.count) return { title, words: GONE, figures: [], outline: [] };
  const at = (name: Parameters<typeof submaps.figure>[1]): number => submaps.figure(index, name);
  const extent = (name: Parameters<typeof submaps.extent>[1]): number => submaps.extent(index, name);
  const isComplete = !Number.isNaN(extent("width"));
  return {
    title,
    fate: isComplete ? "Complete" : "Being made",
    words: "A local map of consecutive scans. Loop closures move it as a whole: what was seen in it keeps its place within.",
    figures: [
      ["x, y", place(at("x"), at("y")), "submap-place", "Where it begins, map frame"],
      ["Heading θ", angle(at("heading")), "submap-heading"],
      ["Keyframes", `${submaps.keyframes(index)}`, "submap-keyframes", "Scans that it keeps"],
      ...(isComplete ? [["Reaches", `${metres(extent("width"))} × ${metres(extent("height"))}`, "submap-extent", "Along the axes of its own frame"] as const, ["Surfaces", `${extent("surfaces")}`, "submap-surfaces"] as const] : []),
      ...(Number.isNaN(at("chi2")) ? [] : [["Residual χ² of its join", chi2Words(at("chi2")), "submap-chi2", "To the submap before"] as const]),
    ],
    outline: ring(at("x"), at("y"), 0.25),
  };
}

const MATERIALS = ["Opaque", "Glass", "Dark"] as const;

const OF_MATERIAL = [
  "The truth, which only a simulator knows. Compare α and r with those of the wall in the map.",
  "The truth, which only a simulator knows. Light goes through glass but where it meets it squarely: most beams end on what stands behind, and the map has no wall here. Sonars hear it.",
  "The truth, which only a simulator knows. A dark wall sends little light back: from farther away it is not seen, and beams say nothing.",
] as const;

/** A wall of the world, given by its row: the line that a perfect map would have. */
export function truth(index: number, { scene: { truth: walls, materials } }: Known): Told {
  const [x1 = NaN, y1 = NaN, x2 = NaN, y2 = NaN] = walls.subarray(4 * index, 4 * index + 4);
  // The normal points from the origin of the map to the wall.
  const normal = Math.atan2(x2 - x1, y1 - y2);
  const signed = x1 * Math.cos(normal) + y1 * Math.sin(normal);
  const alpha = signed < 0 ? Math.atan2(x1 - x2, y2 - y1) : normal;
  const r = Math.abs(signed);
  return {
    title: "Wall of the world",
    fate: MATERIALS[materials[index] ?? 0] ?? "",
    words: OF_MATERIAL[materials[index] ?? 0] ?? OF_MATERIAL[0],
    figures: [
      ["α", angle(alpha, 2), "truth-alpha", "Direction of its normal, map frame"],
      ["r", metres(r), "truth-r", "Distance from where the map begins"],
      ["Length", metres(Math.hypot(x2 - x1, y2 - y1)), "truth-length"],
      ["From", place(x1, y1), "truth-from"],
      ["To", place(x2, y2), "truth-to"],
    ],
    formulas: [{
      general: formula(row(id("x"), fn("cos"), id("α"), op("+"), id("y"), fn("sin"), id("α"), equals(), id("r"))),
      numbers: lineEquation(alpha, r),
      source: t`TDK 2016 § 3.2: the line by its normal, ${fixed(degrees(alpha), 1)}°, m`,
    }],
    outline: segment(x1, y1, x2, y2),
  };
}
