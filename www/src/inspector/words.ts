// Numbers as the inspector writes them, in sentences and formulas.

import { degrees } from "../angle.js";
import { equals, formula, id, op, row } from "../registration/formula.js";
import { fixed, length, list } from "../ui/format.js";

export function metres(value: number): string {
  const { value: text, unit } = length(Math.abs(value));
  return unit === "" ? text : `${value < 0 ? "−" : ""}${text} ${unit}`;
}

export function place(x: number, y: number): string {
  return `${list(fixed(x, 2), fixed(y, 2))} m`;
}

export function angle(radians: number, digits = 1): string {
  return `${fixed(degrees(radians), digits)}°`;
}

/** A number in a formula, with so many significant digits. */
export function number(value: number, digits = 3): Element {
  if (!Number.isFinite(value)) return id("–");
  const size = Math.abs(value);
  const isPlain = size === 0 || (size >= 1e-3 && size < 1e5);
  const text = isPlain ? String(Number(size.toPrecision(digits))) : undefined;
  const [mantissa = "", exponent = ""] = size.toExponential(digits - 1).split("e");
  const written = text ?? `${Number(mantissa)}·10${[...String(Number(exponent))].map((sign) => RAISED[sign] ?? "").join("")}`;
  return value < 0 ? row(op("−"), numeral(written)) : numeral(written);
}

/** Rows of numbers, in brackets. */
export function matrix(rows: readonly (readonly number[])[], digits = 2): Element {
  const element = (tag: string, children: readonly Element[]): Element => {
    const made = document.createElementNS(MATHML, tag);
    made.append(...children);
    return made;
  };
  const table = element("mtable", rows.map((values) => element("mtr", values.map((value) => element("mtd", [number(value, digits)])))));
  return row(op("("), table, op(")"));
}

const MATHML = "http://www.w3.org/1998/Math/MathML";

const RAISED: Readonly<Record<string, string>> = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };

function numeral(text: string): Element {
  const made = document.createElementNS(MATHML, "mn");
  made.append(text);
  return made;
}

/** The same with its sign before it, to follow another term. */
export function added(value: number, digits = 3): Element {
  const sign = op(value < 0 ? "−" : "+");
  // At the beginning of a row the sign would be taken as that of a number.
  sign.setAttribute("form", "infix");
  return row(sign, number(Math.abs(value), digits));
}

/** x cos α + y sin α = r, with numbers. */
export function lineEquation(alpha: number, r: number): Element {
  return formula(row(number(Math.cos(alpha)), op("·"), id("x"), added(Math.sin(alpha)), op("·"), id("y"), equals(), number(r)));
}

