// The value of a setting as people read and type it.

import type { SettingInfo } from "../protocol/module.js";
import { t } from "../words.js";

/** Seven digits cover what people type; the rest are artefacts of binary fractions. */
function plain(value: number): string {
  return Number.isFinite(value) ? String(Number(value.toPrecision(7))) : "";
}

/** The same for display: an angle that is a round number of radians is rounded to three digits. */
function told(value: number): string {
  const isRound = Number(plain(value)) === Number(value.toPrecision(4)) || Math.abs(value) >= 1000;
  return isRound || !Number.isFinite(value) ? plain(value) : String(Number(value.toPrecision(3)));
}

export function written(s: SettingInfo, value: number): string {
  if (s.kind === "choice") return s.choices[value] ?? "";
  if (s.kind === "switch") return value === 0 ? "off" : "on";
  return `${told(s.scale * value)}${s.unit ? ` ${s.unit}` : ""}`;
}

export function range(s: SettingInfo): string {
  return t`${told(s.scale * s.low)} to ${told(s.scale * s.high)}${s.unit ? ` ${s.unit}` : ""}`;
}

const endsOf = ({ low, high, default: byDefault }: SettingInfo): readonly number[] => [low, high, byDefault];

/** The text in the field of a number. The ends of its range and its default are shown rounded. */
export function field(s: SettingInfo, value: number): string {
  return endsOf(s).includes(value) ? told(s.scale * value) : plain(s.scale * value);
}

/** Converts a displayed number to the stored one. An end of the range as displayed is exactly that
    end, in spite of rounding. */
export function stored(s: SettingInfo, shown: number): number {
  const isSame = (end: number): boolean => plain(s.scale * end) === plain(shown) || told(s.scale * end) === plain(shown);
  return endsOf(s).find(isSame) ?? shown / s.scale;
}
