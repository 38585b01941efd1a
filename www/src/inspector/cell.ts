// A cell of the grid: how surely it is occupied, and what one more observation would change. Counts
// of hits and misses are not kept anywhere, only their sum.

import { equals, formula, fraction, id, op, row, sub, sup } from "../registration/formula.js";
import { CELL } from "../protocol/module.js";
import { word } from "../spoken.js";
import { fixed, list } from "../ui/format.js";
import { t } from "../words.js";
import { square } from "./outlines.js";
import type { Figure, Known, Told } from "./told.js";
import { metres, number, place } from "./words.js";

const STATES: readonly string[] = ["Free", "Unknown", "Occupied"];

const chance = (p: number): string => `${fixed(100 * p, 1)} %`;
const odds = (l: number): string => `${l > 0 ? "+" : ""}${fixed(l, 2)}`;

export function cell(x: number, y: number, { examined }: Known): Told {
  if (!examined) return { title: "Cell of the grid", figures: [["Where", place(x, y), "cell-where"]], outline: [] };
  const at = (name: keyof typeof CELL): number => examined.cell[CELL[name]] ?? NaN;
  const [side, l, p] = [at("resolution"), at("logOdds"), at("probability")];
  const [middleX, middleY] = [(at("col") + 0.5) * side, (at("row") + 0.5) * side];
  const sonars = at("ofSonars");
  const both: Figure[] = Number.isNaN(sonars) ? [] : [
    ["By the sensor alone", odds(at("ofSensor")), "cell-sensor", word("Log-odds")],
    ["By the sonars alone", odds(sonars), "cell-sonars", "Log-odds; what both say adds up"],
  ];
  return {
    title: t`Cell ${fixed(at("col"), 0)}, ${fixed(at("row"), 0)}`,
    fate: STATES[at("state") + 1] ?? "",
    words: l === 0 ? "No beam has said anything of it, or as much for it as against." : "Each scan whose beam ends in it adds a hit, each whose beams pass through it a miss; the sum is kept, the counts are not.",
    figures: [
      ["p(occupied)", chance(p), "cell-p", "Probability that something stands in it: below 35 % it counts as free, above 65 % as occupied"],
      ["Log-odds l", odds(l), "cell-l", "ln(p / (1 − p)), 0 where nothing is known"],
      ["After one more hit", chance(at("afterHit")), "cell-after-hit", "p if the next scan ends in it"],
      ["After one more miss", chance(at("afterMiss")), "cell-after-miss", "p if the next scan passes through it"],
      ["A hit adds", odds(at("hit")), "cell-hit", word("Log-odds")],
      ["A miss adds", odds(at("miss")), "cell-miss", word("Log-odds")],
      ["Kept within", `±${fixed(at("limit"), 2)}`, "cell-limit", "Log-odds of one sensor go no further, so that the map can change its mind"],
      ["Middle", `${list(fixed(middleX, 3), fixed(middleY, 3))} m`, "cell-where", "Map frame"],
      ["Side", metres(side), "cell-side"],
      ...both,
    ],
    formulas: [{
      general: formula(row(id("p"), equals(), id("1"), op("−"), fraction(id("1"), row(id("1"), op("+"), sup(id("e"), id("l")))))),
      numbers: formula(row(id("1"), op("−"), fraction(id("1"), row(id("1"), op("+"), sup(id("e"), number(l)))), equals(), number(p))),
      source: "Celej § 3, recovery of probabilities, with the erratum of the specification",
    }, {
      general: formula(row(id("l"), op("←"), id("l"), op("+"), sub(id("l"), id("hit")), op(","), id("l"), op("+"), sub(id("l"), id("miss")))),
      numbers: formula(row(number(l), op("+"), number(at("hit")), op(","), number(l), op("−"), number(-at("miss")))),
      source: "Celej § 3, log-odds; kept within the limit",
    }],
    outline: square(middleX, middleY, side),
  };
}
