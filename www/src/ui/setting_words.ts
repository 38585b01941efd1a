// The number of a setting as people read and type it.

import type { SettingInfo } from "../protocol/module.js";
import { t } from "../words.js";

/** What an input holds: seven digits say what anybody typed; the others are those of the binary
    number. */
export function plain(value: number): string {
  return Number.isFinite(value) ? String(Number(value.toPrecision(7))) : "";
}

export function written(s: SettingInfo, value: number): string {
  if (s.kind === "choice") return s.choices[value] ?? "";
  if (s.kind === "switch") return value === 0 ? "off" : "on";
  return `${Number((s.scale * value).toPrecision(4))}${s.unit ? ` ${s.unit}` : ""}`;
}

export function range(s: SettingInfo): string {
  return t`${plain(s.scale * s.low)} to ${plain(s.scale * s.high)}${s.unit ? ` ${s.unit}` : ""}`;
}

/** The number to be stored for one as people read it; an end of the range as it is written is that
    end. */
export function stored(s: SettingInfo, shown: number): number {
  const value = shown / s.scale;
  return [s.low, s.high, s.default].find((end) => plain(s.scale * end) === plain(shown)) ?? value;
}
