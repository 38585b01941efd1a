// The card of a story beside the map: a heading, a few sentences, a cross to close it.

import { css } from "lit";

export const story = css`
  section { width: 340px; padding: 14px 16px 12px; border: 1px solid var(--line); border-radius: 16px; background: var(--raised); box-shadow: var(--shadow); animation: in .25s ease-out; }
  @keyframes in { from { opacity: 0; transform: translateY(-6px); } }
  header { display: flex; align-items: start; gap: 8px; }
  h2 { flex: 1; margin: 0; font: 620 17px/1.25 var(--sans); letter-spacing: -.01em; text-transform: none; color: var(--ink); }
  header button { margin: -8px -10px 0 0; border-color: transparent; background: transparent; }
  p { margin: 6px 0 10px; line-height: 1.5; }
  @media (max-width: 760px) { section { width: auto; padding: 10px 12px; } p { font-size: 13.5px; line-height: 1.4; margin-bottom: 6px; } }
`;
