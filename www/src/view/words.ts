// What is under the pointer, in words.

import { fixed } from "../ui/format.js";
import { t } from "../words.js";
import type { Reading } from "./things.js";
import type { GridView } from "./tiles.js";

/** What a byte of a field says. */
export function fieldWords(view: GridView, byte: number, step: number): string {
  const [value, more] = [(byte - 1) * step, byte === 255 ? "≥ " : ""];
  if (view === "likelihood") return t`likelihood ${fixed(value, 2)}`;
  if (view === "room") return byte === 1 ? t("the robot may not be here") : t`the robot's middle has ${more}${fixed(value, 2)} m of room`;
  return t`${more}${fixed(value, 2)} m to the nearest wall`;
}

/** What the sensor said of a hit: the range with its σ, and how strong the echo was, if it reports
    that. */
export function readingWords({ range, sigma, quality }: Reading): string {
  const strength = Number.isNaN(quality) ? "" : t`, quality ${quality}`;
  return t`beam ${fixed(range, 2)} ± ${fixed(sigma, 2)} m${strength}`;
}

export function metres(value: number): string {
  return (value < 0 ? "−" : "") + fixed(Math.abs(value), 2);
}
