// What is under the pointer, in words.

import type { Reading } from "./layers/scan.js";
import type { GridView } from "./tiles.js";

/** What a byte of a field says. */
export function fieldWords(view: GridView, byte: number, step: number): string {
  const [value, more] = [(byte - 1) * step, byte === 255 ? "at least " : ""];
  if (view === "likelihood") return `likelihood ${value.toFixed(2)}`;
  if (view === "room") return byte === 1 ? "the robot may not be here" : `the robot's middle has ${more}${value.toFixed(2)} m of room`;
  return `${more}${value.toFixed(2)} m to the nearest wall`;
}

/** What the sensor said of a hit: the range with its σ, and how strong the echo was, if it reports
    that. */
export function readingWords({ range, sigma, quality }: Reading): string {
  const strength = Number.isNaN(quality) ? "" : `, quality ${quality}`;
  return `beam ${range.toFixed(2)} ± ${sigma.toFixed(2)} m${strength}`;
}

export function metres(value: number): string {
  return (value < 0 ? "−" : "") + Math.abs(value).toFixed(2);
}
