// Numbers as people read them.

import { decimalMark } from "../spoken.js";

export const DASH = "–";

export function fixed(value: number, digits: number): string {
  if (!Number.isFinite(value)) return DASH;
  const text = Math.abs(value).toFixed(digits);
  const shown = text.replace(".", decimalMark());
  // A number that rounds to zero has no sign.
  return value < 0 && Number(text) !== 0 ? `−${shown}` : shown;
}

/** A list of numbers. The separator is not a comma if a comma is the decimal mark. */
export const list = (...numbers: readonly string[]): string => numbers.join(decimalMark() === "," ? "; " : ", ");

/** For example, 83 s is 1:23. */
export function clock(seconds: number): string {
  if (!Number.isFinite(seconds)) return DASH;
  const whole = Math.floor(Math.max(0, seconds));
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  const two = (n: number): string => String(n).padStart(2, "0");
  return h > 0 ? `${h}:${two(m)}:${two(s)}` : `${m}:${two(s)}`;
}

export function percent(fraction: number): string {
  return Number.isFinite(fraction) ? `${Math.floor(fraction * 100)} %` : DASH;
}

/** A length in a suitable unit: 4.2 cm reads better than 0.04 m. */
export function length(metres: number): { value: string; unit: string } {
  if (!Number.isFinite(metres)) return { value: DASH, unit: "" };
  return metres < 1 ? { value: fixed(metres * 100, 1), unit: "cm" } : { value: fixed(metres, 2), unit: "m" };
}

/** Starts with a capital letter. */
export function sentence(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
