// How runs side by side are distinguished: by colour, and by the dashes of their lines.

import type { TemplateResult } from "lit";
import type { PaletteName } from "../view/palette.js";
import { html } from "../words.js";

/** Most runs side by side. */
export const MOST_RUNS = 4;

/** The run that is shown comes first, then those beside it. */
export const COLOURS = ["estimate", "contest3", "contest5", "contest2"] as const satisfies readonly PaletteName[];
export type RunColour = (typeof COLOURS)[number];
export const DASHES: readonly (readonly number[])[] = [[], [7, 3], [2, 3], [9, 3, 2, 3]];

/** A sample of its line. */
export function swatch(colour: PaletteName, place: number): TemplateResult {
  return html`<svg class="line" viewBox="0 0 20 8" aria-hidden="true"><path d="M0 4h20" stroke="var(--map-${colour})" stroke-width="3" stroke-linecap="butt" stroke-dasharray=${(DASHES[place] ?? []).join(" ")}/></svg>`;
}
