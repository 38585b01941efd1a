// Figures with their names, in two columns.

import { css, type TemplateResult } from "lit";
import { html } from "../words.js";

export const figures = css`
  dl { display: grid; grid-template-columns: 1fr 1fr; column-gap: 20px; margin: 0; font-size: 13px; }
  dl div { display: flex; justify-content: space-between; gap: 8px; padding: 4px 0; border-bottom: 1px solid color-mix(in srgb, var(--line) 60%, transparent); }
  dl .wide { grid-column: 1 / -1; }
  dt { color: var(--muted); }
  dd { margin: 0; text-align: right; overflow-wrap: anywhere; }
`;

/** One figure; tests use `id`, and `title` explains it. */
export function figure(name: string, value: unknown, id: string, title = "", wide = ""): TemplateResult {
  return html`<div class=${wide} title=${title}><dt>${name}</dt><dd class="num" data-testid=${id}>${value}</dd></div>`;
}
