// The common style of all components: buttons, fields, panels. Colours and fonts are custom
// properties of style.css.

import { css } from "lit";

/** A tool that can be folded: a sentence, some fields, a picture. */
export const tool = css`
  :host { border-top: 1px solid var(--line); margin-top: 14px; padding-top: 4px; }
  p { margin: 6px 0 8px; font-size: 12.5px; line-height: 1.5; color: var(--muted); }
  p b { color: var(--ink); font-weight: 500; }
  code { font: 500 12px/1 var(--mono); color: var(--ink); }
  p.bad { color: var(--warn-ink); }
  p.good { color: var(--good-ink); }
  figure { margin: 0 0 10px; }
  figcaption { display: flex; justify-content: space-between; gap: 8px; font-size: 12.5px; margin-bottom: 2px; }
  .plot { height: 150px; }
  .apply { width: 100%; margin-bottom: 8px; white-space: normal; }
`;

/** A section of a tab: its heading and the text below it. */
export const section = css`
  h2 { margin: 18px 0 8px; }
  p { margin: 0 0 8px; font-size: 12.5px; line-height: 1.4; color: var(--muted); }
  p.bad { color: var(--warn-ink); font-weight: 600; }
`;

/** A picture of an opened file in a section, and its name. */
export const picture = css`
  p b { color: var(--ink); font-weight: 600; overflow-wrap: anywhere; }
  canvas { display: block; width: 100%; height: 190px; margin-bottom: 8px; border: 1px solid var(--line); border-radius: 10px; }
`;

export const shared = css`
  *, *::before, *::after { box-sizing: border-box; }
  :host { display: block; font: 400 14px/1.45 var(--sans); color: var(--ink); }
  :host([hidden]), [hidden] { display: none; }
  :focus-visible { outline: 2px solid var(--focus); outline-offset: 2px; }
  button, select, input { font: inherit; color: inherit; }
  button, .button {
    display: inline-flex; align-items: center; justify-content: center; gap: 7px; min-height: 36px; padding: 0 12px;
    border: 1px solid var(--line); border-radius: 9px; background: var(--raised); cursor: pointer; font-weight: 550;
    transition: background .12s, border-color .12s, transform .08s; white-space: nowrap; user-select: none;
  }
  button:hover, .button:hover { border-color: var(--line-strong); background: var(--hover); }
  button:active { transform: translateY(1px); }
  button:disabled { opacity: .45; cursor: default; transform: none; }
  button.icon { width: 36px; padding: 0; }
  svg { width: 18px; height: 18px; flex: none; fill: none; stroke: currentColor; stroke-width: 1.8; stroke-linecap: round; stroke-linejoin: round; }
  select, input[type="number"], input[type="text"] {
    min-height: 36px; width: 100%; padding: 0 10px; border: 1px solid var(--line); border-radius: 9px; background: var(--raised);
  }
  /* Names are longer in other languages than the fields are wide. */
  select { text-overflow: ellipsis; }
  input[type="file"] { position: absolute; width: 1px; height: 1px; opacity: 0; }
  input[type="file"]:focus-visible + .button { outline: 2px solid var(--focus); outline-offset: 2px; }
  summary { cursor: pointer; font-weight: 550; font-size: 13.5px; min-height: 40px; display: flex; align-items: center; list-style: none; }
  summary::before { content: "›"; width: 10px; margin-right: 6px; line-height: 1; text-align: center; color: var(--muted); transition: transform .12s; }
  summary::-webkit-details-marker { display: none; }
  details[open] > summary::before { transform: rotate(90deg); }
  h2 { margin: 0; font: 600 11px/1 var(--sans); letter-spacing: .09em; text-transform: uppercase; color: var(--muted); }
  .num { font-family: var(--mono); font-variant-numeric: tabular-nums; }
  .muted { color: var(--muted); }
  @media (pointer: coarse) { button, .button, select, input[type="number"] { min-height: 44px; } button.icon { width: 44px; } }
  @media (prefers-reduced-motion: reduce) { * { transition: none !important; animation: none !important; } }
`;
