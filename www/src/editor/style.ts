// The layout of the editor: tools above, then board and panel side by side, or one below the other
// on a phone.

import { css } from "lit";

export const layout = css`
  :host { position: fixed; inset: 56px 0 0; z-index: 20; background: var(--page); outline: none; }
  .page { height: 100%; padding: 10px 14px 14px; display: grid; grid-template: auto minmax(0, 1fr) / minmax(0, 1fr) 300px; gap: 10px; }
  .head { grid-column: 1 / -1; display: flex; flex-wrap: wrap; align-items: center; gap: 8px; }
  h2 { font: 620 20px/1.2 var(--sans); letter-spacing: -.02em; text-transform: none; color: var(--ink); white-space: nowrap; margin-right: 6px; }
  .tools { display: flex; gap: 5px; flex-wrap: wrap; }
  .tools button { padding: 0 10px; }
  button[aria-pressed="true"] { border-color: var(--accent); box-shadow: inset 0 0 0 1px var(--accent); color: var(--accent-ink); }
  .grow { flex: 1; }
  .run { background: var(--accent); color: var(--on-accent); border-color: transparent; }
  .run:hover { background: var(--accent-ink); border-color: transparent; }
  .side { min-height: 0; overflow-y: auto; display: flex; flex-direction: column; gap: 12px; padding: 14px; border: 1px solid var(--line); border-radius: 12px; background: var(--surface); scrollbar-width: thin; }
  .side p { margin: 0; font-size: 13px; line-height: 1.45; }
  h3 { margin: 0 0 8px; font: 620 15px/1.2 var(--sans); }
  .fields { display: grid; grid-template-columns: 1fr 1fr; gap: 8px; }
  label { display: grid; gap: 3px; font-size: 12.5px; color: var(--muted); }
  label > input, label > select { color: var(--ink); font-size: 14px; }
  .wide, .check { grid-column: 1 / -1; }
  .check { display: flex; align-items: center; gap: 8px; min-height: 32px; color: var(--ink); font-size: 13.5px; }
  .check input { width: 17px; height: 17px; accent-color: var(--accent); }
  .row { display: flex; flex-wrap: wrap; gap: 6px; margin-top: 10px; }
  .row button, .row .button { min-height: 34px; font-size: 13px; padding: 0 10px; }
  .said { padding: 9px 11px; border-radius: 10px; border: 1px solid var(--line); }
  .bad { border-color: var(--warn); color: var(--warn-ink); }
  hr { width: 100%; border: 0; border-top: 1px solid var(--line); margin: 0; }
  .file { position: relative; display: contents; }
  .file .button { color: var(--ink); font-size: 13px; }
  @media (max-width: 1000px) {
    .head { gap: 5px; }
    h2 { display: none; }
    .tools { gap: 3px; }
    .tools button { padding: 0 6px; font-size: 13px; }
  }
  @media (max-width: 760px) {
    :host { inset: 54px 0 0; }
    .page { padding: 8px; gap: 8px; grid-template: auto minmax(0, 1.5fr) minmax(0, 1fr) / minmax(0, 1fr); }
    h2, .grow { display: none; }
    .tools { width: 100%; padding: 2px; }
    .tools button { flex: 1 0 auto; }
    .run { flex: 1; }
    .side { padding: 10px; }
  }
`;
