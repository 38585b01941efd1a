// Formulas in MathML, which every browser renders by itself.

const NAMESPACE = "http://www.w3.org/1998/Math/MathML";

function element(tag: string, ...children: (Element | string)[]): Element {
  const made = document.createElementNS(NAMESPACE, tag);
  made.append(...children);
  return made;
}

export const formula = (inner: Element): Element => {
  const math = element("math", inner);
  math.setAttribute("display", "block");
  return math;
};
/** A letter or a number. */
export const id = (name: string): Element => element(/^[\d.]+$/.test(name) ? "mn" : "mi", name);
export const op = (sign: string): Element => element("mo", sign);
export const equals = (): Element => op("=");
/** A name of more than one letter, upright. */
export const fn = (name: string): Element => {
  const made = element("mi", name);
  made.setAttribute("mathvariant", "normal");
  return made;
};
export const text = (words: string): Element => element("mtext", words);
export const row = (...parts: Element[]): Element => element("mrow", ...parts);
export const sub = (base: Element, index: Element): Element => element("msub", base, index);
export const sup = (base: Element, power: Element | string): Element => element("msup", base, typeof power === "string" ? exponent(power) : power);
export const subsup = (base: Element, index: string, power: string): Element => element("msubsup", base, id(index), exponent(power));
export const fraction = (above: Element, below: Element): Element => element("mfrac", above, below);
export const norm = (inner: Element): Element => row(op("‖"), inner, op("‖"));
export const hat = (base: Element): Element => element("mover", base, op("^"));
/** A sum over an index. */
export const sum = (index: string): Element => element("munder", op("∑"), id(index));

function exponent(power: string): Element {
  if (power.startsWith("−")) return row(op("−"), id(power.slice(1)));
  return power === "T" ? fn("⊤") : id(power);
}
