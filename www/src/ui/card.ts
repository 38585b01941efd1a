// The card for what was chosen on the map: figures, a head and a cross to close it.

import { css } from "lit";

export const card = css`
  section { width: min(400px, calc(100vw - 24px)); padding: 12px 14px; border: 1px solid var(--line); border-radius: 14px; background: var(--raised); box-shadow: var(--shadow); animation: in .18s ease-out; }
  @keyframes in { from { opacity: 0; transform: translateY(6px); } }
  header { display: flex; align-items: center; gap: 9px; margin-bottom: 6px; }
  header b { flex: 1; font-weight: 600; }
  header svg { flex: none; }
  header button { border-color: transparent; background: transparent; min-height: 30px; width: 30px; }
  p { margin: 0 0 8px; font-size: 13px; line-height: 1.45; }
  @media (pointer: coarse) { header button { min-height: 44px; width: 44px; margin: -8px -8px -8px 0; } }
  @media (max-width: 760px) { section { margin: 0 12px; } }
`;
