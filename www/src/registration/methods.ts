// Texts about each registration method: its name, what it does, its formula with the equation
// number of its source, and the meaning of its width.

import { equals, fn, fraction, hat, id, norm, op, row, sub, subsup, sum, sup, text, formula } from "./formula.js";

export interface MethodWords {
  readonly title: string;
  readonly meaning: string;
  readonly formula: () => Element;
  /** The paper, and the number of the equation in it. */
  readonly source: string;
  /** The meaning of the width of an iteration. */
  readonly width: string;
  /** The meaning of the first width, if it is another. */
  readonly firstWidth?: string;
  readonly isCell?: boolean;
}

const T = (): Element => row(id("R"), sub(id("p"), id("i")), op("+"), id("t"));

export const METHODS: Readonly<Record<string, MethodWords>> = {
  "point-to-point": {
    title: "ICP, point to point",
    meaning: "Each point is pulled to the nearest one; the best motion of all pairs has a closed form.",
    formula: () => formula(row(id("E"), op("="), fraction(id("1"), id("n")), sum("i"), sup(norm(row(sub(id("x"), id("i")), op("−"), id("R"), sub(id("p"), id("i")), op("−"), id("t"))), "2"))),
    source: "Pilch 2016, eq. (1.26); Besl & McKay 1992",
    width: "kernel",
  },
  "point-to-line": {
    title: "ICP, point to line",
    meaning: "Only the distance across the line through the partner counts: a point may slide along its wall.",
    formula: () => formula(row(id("E"), op("="), sum("i"), sup(row(op("("), subsup(id("n"), "i", "T"), op("("), T(), op("−"), sub(id("x"), id("i")), op(")"), op(")")), "2"))),
    source: "Censi 2008, § III (metric)",
    width: "kernel",
  },
  "surface-to-surface": {
    title: "ICP, surface to surface",
    meaning: "Both points are sure across their surface and unsure along it.",
    formula: () => formula(row(id("E"), op("="), sum("i"), subsup(id("d"), "i", "T"), sup(row(op("("), subsup(id("C"), "i", "X"), op("+"), id("R"), subsup(id("C"), "i", "P"), sup(id("R"), "T"), op(")")), "−1"), sub(id("d"), id("i")))),
    source: "Segal, Haehnel & Thrun 2009, § III",
    width: "kernel",
  },
  ndt: {
    title: "NDT",
    meaning: "The fixed cloud becomes a normal distribution in each cell; the moving points are made as likely as can be.",
    formula: () => formula(row(id("s"), op("="), sum("i"), fn("exp"), op("("), op("−"), fraction(id("1"), id("2")), subsup(id("d"), "i", "T"), subsup(id("Σ"), "i", "−1"), sub(id("d"), id("i")), op(")"))),
    source: "Biber & Straßer 2003, score of § IV",
    width: "cell",
    isCell: true,
  },
  cpd: {
    title: "CPD",
    meaning: "Moving points are centres of Gaussians; every fixed point belongs to all of them in part. σ shrinks by itself.",
    formula: () => formula(row(sub(id("p"), id("mn")), op("="), fraction(
      sup(id("e"), row(op("−"), sup(norm(row(sub(id("x"), id("n")), op("−"), id("T"), sub(id("y"), id("m")))), "2"), op("/"), id("2"), sup(id("σ"), "2"))),
      row(sum("k"), sup(id("e"), row(op("−"), sup(norm(row(sub(id("x"), id("n")), op("−"), id("T"), sub(id("y"), id("k")))), "2"), op("/"), id("2"), sup(id("σ"), "2"))), op("+"), id("c")),
    ))),
    source: "Pilch 2016, eq. (1.45); Myronenko & Song 2010",
    width: "σ",
  },
  gmm: {
    title: "Gaussian mixtures",
    meaning: "Both clouds are mixtures; their squared difference is made least, from wide Gaussians to narrow ones.",
    formula: () => formula(row(sub(id("d"), text("L2")), op("="), op("∫"), sup(row(op("("), fn("gmm"), op("("), id("S"), op(")"), op("−"), fn("gmm"), op("("), id("T"), id("M"), op(")"), op(")")), "2"), fn("d"), id("x"))),
    source: "Pilch 2016, eq. (1.58); Jian & Vemuri 2011",
    width: "σ",
  },
  correlation: {
    title: "Correlation",
    meaning: "Branch and bound finds the best pose of a whole window for sure; points to lines make it exact.",
    formula: () => formula(row(hat(id("ξ")), equals(), sub(fn("arg max"), row(id("ξ"), op("∈"), id("W"))), sum("k"), id("M"), op("("), sub(id("T"), id("ξ")), sub(id("h"), id("k")), op(")"))),
    source: "Hess et al. 2016, eq. (BBS)",
    width: "kernel",
    firstWidth: "window",
  },
};

/** A method that the core has and this table lacks has only its name. */
export function wordsOf(name: string): MethodWords {
  return METHODS[name] ?? { title: name, meaning: "", formula: () => formula(row()), source: "", width: "width" };
}
