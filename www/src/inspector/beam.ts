// A beam of the last scan: its range, the range that the map predicts, and how likely the
// measurement is by the two usual models of a range sensor.

import { EXAMINED_BEAM, type MethodName } from "../protocol/module.js";
import { equals, formula, fraction, hat, id, op, row, sub, sup } from "../registration/formula.js";
import { fixed } from "../ui/format.js";
import { t } from "../words.js";
import { segment } from "./outlines.js";
import { type Figure, GONE, type Known, type Told } from "./told.js";
import { metres, number } from "./words.js";

/** How each method uses a single beam. */
const USED: Readonly<Record<MethodName, string>> = {
  odometry: "The pose does not depend on it: the method counts wheels only, and the map is drawn with it.",
  "line-ekf": "The filter does not weigh beams one by one: it fits lines to them, and matches those. The map is drawn with it.",
  "scan-matching": "Scan matching pulls the ends of all beams together onto the surfaces of the map. The map is drawn with it.",
  "grid-particles": "Each particle weighs the ends of all beams by the map that is its own. This is the likeliest map.",
  "prior-map": "Lines that are fitted to the beams are matched with walls of the prior map.",
  "particle-localisation": "Each particle is weighed by the distances of the ends of beams from the nearest wall of the prior map.",
  "histogram-localisation": "Each cell of the histogram is weighed by the distances of the ends of beams from the nearest wall of the prior map.",
};

/** The residual, in standard deviations, beyond which it is not noise. */
const BEYOND = 3;

export function beam(number_: number, { store, examined }: Known): Told {
  const title = t`Beam ${number_}`;
  if (!examined) return { title, figures: [], outline: [] };
  const { beam: told } = examined;
  if (!told) return { title, words: GONE, figures: [], outline: [] };
  const at = (name: keyof typeof EXAMINED_BEAM): number => told[EXAMINED_BEAM[name]] ?? NaN;
  const [z, sigma, expected, d, fieldSigma, random] = [at("range"), at("sigma"), at("expected"), at("nearest"), at("fieldSigma"), at("random")];
  const isOfWalls = at("walls") === 1;
  // A grid knows a surface to one cell, and the beam is compared with that.
  const spread = isOfWalls ? sigma : fieldSigma;
  const residual = z - expected;
  const density = Math.exp(-0.5 * (residual / spread) ** 2) / (Math.sqrt(2 * Math.PI) * spread);
  const likelihood = (1 - random) * (Number.isNaN(d) ? 0 : Math.exp(-0.5 * (d / fieldSigma) ** 2)) + random;
  const figures: Figure[] = [
    ["Range z", metres(z), "beam-range"],
    ["σ of it", metres(sigma), "beam-sigma", "Standard deviation, by the model of the sensor"],
    ...(Number.isNaN(at("quality")) ? [] : [["Quality", fixed(at("quality"), 0), "beam-quality", "Strength of the echo, in the sensor's own unit"] as const]),
    ["Range in the map ẑ", Number.isNaN(expected) ? "–" : metres(expected), "beam-expected", "To the first surface on its way in the map, from where the robot believes to be"],
    ["Residual z − ẑ", Number.isNaN(residual) ? "–" : `${metres(residual)} (${fixed(residual / spread, 1)} σ)`, "beam-residual", "Of a map of cells: to within a cell"],
    ["From the nearest surface d", Number.isNaN(d) ? "–" : metres(d), "beam-nearest", "Of the end of the beam"],
    ["Likelihood q", fixed(likelihood, 3), "beam-likelihood", "1 where it ends on a surface"],
  ];
  return {
    title,
    fate: fate(residual, spread),
    words: isOfWalls ? t(USED[store.method]) : t`${t(USED[store.method])} By now the scan is part of the map: where nothing was known before, a beam agrees with itself.`,
    figures,
    formulas: [{
      general: formula(row(sub(id("p"), id("hit")), equals(), fraction(id("1"), row(op("√"), op("("), id("2"), id("π"), op(")"), id("σ"))), sup(id("e"), row(op("−"), fraction(sup(row(op("("), id("z"), op("−"), hat(id("z")), op(")")), "2"), row(id("2"), sup(id("σ"), "2"))))))),
      numbers: formula(row(fraction(id("1"), row(op("√"), op("("), id("2"), id("π"), op(")"), number(spread))), sup(id("e"), row(op("−"), fraction(sup(row(op("("), number(residual), op(")")), "2"), row(id("2"), op("·"), sup(number(spread), "2"))))), equals(), number(density))),
      source: isOfWalls
        ? "Thrun, Burgard & Fox 2005, eq. (6.4): beam model, density per metre"
        : "Thrun, Burgard & Fox 2005, eq. (6.4): beam model, density per metre; σ with what a cell adds",
    }, {
      general: formula(row(id("q"), equals(), op("("), id("1"), op("−"), id("ρ"), op(")"), sup(id("e"), row(op("−"), fraction(sup(id("d"), "2"), row(id("2"), sup(sub(id("σ"), id("d")), "2"))))), op("+"), id("ρ"))),
      numbers: formula(row(number(1 - random), op("·"), sup(id("e"), row(op("−"), fraction(sup(number(d), "2"), row(id("2"), op("·"), sup(number(fieldSigma), "2"))))), op("+"), number(random), equals(), number(likelihood))),
      source: "Thrun, Burgard & Fox 2005, table 6.3: likelihood field; ρ is the part of beams that hit what is not in the map",
    }],
    outline: segment(at("fromX"), at("fromY"), at("x"), at("y")),
  };
}

function fate(residual: number, sigma: number): string {
  if (Number.isNaN(residual)) return "Nothing stands there in the map";
  if (Math.abs(residual) <= BEYOND * sigma) return "Agrees with the map";
  return residual < 0 ? "Shorter than the map has it" : "Longer than the map has it";
}
