// Line icons, drawn on 24 x 24.

import type { TemplateResult } from "lit";
import { html, svg } from "../words.js";

const icon = (paths: TemplateResult<2>): TemplateResult => html`<svg viewBox="0 0 24 24" aria-hidden="true">${paths}</svg>`;

export const icons = {
  play: icon(svg`<path d="M7 4.5v15l12.5-7.5z" fill="currentColor"/>`),
  pause: icon(svg`<path d="M8 5v14M16 5v14" stroke-width="3.4"/>`),
  step: icon(svg`<path d="M5 5v14l10-7z" fill="currentColor"/><path d="M19 5v14" stroke-width="2.6"/>`),
  back: icon(svg`<path d="M19 5v14L9 12z" fill="currentColor"/><path d="M5 5v14" stroke-width="2.6"/>`),
  stop: icon(svg`<path d="M8.2 3h7.6L21 8.2v7.6L15.8 21H8.2L3 15.8V8.2z" fill="currentColor" stroke="none"/>`),
  beside: icon(svg`<rect x="3.5" y="5" width="7" height="14" rx="1.8"/><rect x="13.5" y="5" width="7" height="14" rx="1.8"/>`),
  plus: icon(svg`<path d="M12 5v14M5 12h14"/>`),
  minus: icon(svg`<path d="M5 12h14"/>`),
  inspect: icon(svg`<circle cx="10.5" cy="10.5" r="6.5"/><path d="m15.5 15.5 5 5M10.5 10v3.5"/><path d="M10.5 7.4h.01" stroke-width="2.4"/>`),
  pencil: icon(svg`<path d="M4 20l1-4.5L16.5 4a2.1 2.1 0 0 1 3 0l.5.5a2.1 2.1 0 0 1 0 3L8.5 19z"/><path d="m14.5 6 3.5 3.5"/>`),
  undo: icon(svg`<path d="M8.5 5 4 9.5 8.5 14"/><path d="M4.5 9.5H14a5 5 0 0 1 0 10h-3"/>`),
  fit: icon(svg`<path d="M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5"/>`),
  follow: icon(svg`<circle cx="12" cy="12" r="6.5"/><path d="M12 2.5v4M12 17.5v4M2.5 12h4M17.5 12h4"/><circle cx="12" cy="12" r="1.6" fill="currentColor"/>`),
  sun: icon(svg`<circle cx="12" cy="12" r="4.2"/><path d="M12 2.5v2.3M12 19.2v2.3M2.5 12h2.3M19.2 12h2.3M5.3 5.3l1.6 1.6M17.1 17.1l1.6 1.6M18.7 5.3l-1.6 1.6M6.9 17.1l-1.6 1.6"/>`),
  moon: icon(svg`<path d="M20 14.2A8.3 8.3 0 0 1 9.8 4 8.3 8.3 0 1 0 20 14.2z"/>`),
  help: icon(svg`<circle cx="12" cy="12" r="9"/><path d="M9.4 9.3a2.7 2.7 0 1 1 4 2.6c-.9.5-1.4 1-1.4 2"/><path d="M12 17h.01" stroke-width="2.4"/>`),
  open: icon(svg`<path d="M3.5 18.5v-12h6l2 2.5h9v9.5z"/><path d="M12 16.5v-5M9.7 13.6 12 11.3l2.3 2.3"/>`),
  save: icon(svg`<path d="M12 4v11M7.5 10.5 12 15l4.5-4.5M4.5 19.5h15"/>`),
  image: icon(svg`<rect x="3.5" y="5" width="17" height="14" rx="2"/><path d="m4 16.5 5-5 4.5 4.5 2.5-2.5 4 4"/><circle cx="15.5" cy="9.3" r="1.2"/>`),
  dice: icon(svg`<rect x="4" y="4" width="16" height="16" rx="3.5"/><path d="M8.6 8.6h.01M15.4 15.4h.01M15.4 8.6h.01M8.6 15.4h.01M12 12h.01" stroke-width="2.6"/>`),
  again: icon(svg`<path d="M19.5 12a7.5 7.5 0 1 1-2.3-5.4L19.5 9"/><path d="M19.5 4v5h-5"/>`),
  hand: icon(svg`<path d="M12 3.5v17M3.5 12h17M12 3.5 9.7 6M12 3.5 14.3 6M12 20.5 9.7 18M12 20.5l2.3-2.5M3.5 12 6 9.7M3.5 12 6 14.3M20.5 12 18 9.7M20.5 12 18 14.3"/>`),
  eye: icon(svg`<path d="M2.5 12S6 5.5 12 5.5 21.5 12 21.5 12 18 18.5 12 18.5 2.5 12 2.5 12z"/><circle cx="12" cy="12" r="2.8"/>`),
  hidden: icon(svg`<path d="M4 14.5c2 2.4 4.7 4 8 4 6 0 9.5-6.5 9.5-6.5a16 16 0 0 0-2.6-3.5M16.5 6.6A9.3 9.3 0 0 0 12 5.5C6 5.5 2.5 12 2.5 12"/><path d="M4 20 20 4"/>`),
  bin: icon(svg`<path d="M4.5 7h15M9 7V4.5h6V7M6.5 7l1 13h9l1-13M10 11v5.5M14 11v5.5"/>`),
  pin: icon(svg`<path d="M12 21s6.5-5.8 6.5-11A6.5 6.5 0 0 0 5.5 10c0 5.2 6.5 11 6.5 11z"/><circle cx="12" cy="10" r="2.3"/>`),
  arrow: icon(svg`<path d="M12 19V5.5M6.5 11 12 5.5l5.5 5.5"/>`),
  /** A needle that points along the map's y axis, turned by so many degrees. */
  needle: (turned: number): TemplateResult => icon(svg`<g transform="rotate(${-turned} 12 12)"><path d="M12 3.5 8.5 12h7z" fill="currentColor"/><path d="M12 20.5 8.5 12h7z"/></g>`),
  compass: icon(svg`<circle cx="12" cy="12" r="9"/><path d="m15.8 8.2-2.2 5.4-5.4 2.2 2.2-5.4z"/>`),
  cycle: icon(svg`<path d="M12 4a8 8 0 0 1 7.6 5.5M19.9 13a8 8 0 0 1-5 6.4M11 20a8 8 0 0 1-6.6-5M4.1 11A8 8 0 0 1 9 4.6"/><path d="M19.8 5v4.6h-4.6"/>`),
  flask: icon(svg`<path d="M9.5 3.5h5M10.5 3.5v6L5 18.6a1.3 1.3 0 0 0 1.1 2h11.8a1.3 1.3 0 0 0 1.1-2l-5.5-9.1v-6"/><path d="M7.6 14.5h8.8"/>`),
  link: icon(svg`<path d="M10 14a4 4 0 0 0 5.7 0l3.3-3.3a4 4 0 0 0-5.7-5.7l-1.2 1.2"/><path d="M14 10a4 4 0 0 0-5.7 0L5 13.3a4 4 0 0 0 5.7 5.7l1.2-1.2"/>`),
  close: icon(svg`<path d="M6 6l12 12M18 6 6 18"/>`),
  layers: icon(svg`<path d="m12 3.5 9 4.8-9 4.8-9-4.8z"/><path d="m3 12.5 9 4.8 9-4.8M3 16.6l9 4.8 9-4.8" opacity=".7"/>`),
  gauge: icon(svg`<path d="M4 17a8.5 8.5 0 1 1 16 0"/><path d="m12 14 4-5"/>`),
  chart: icon(svg`<path d="M4 4v16h16"/><path d="m7 15 4-5 3 3 5-7"/>`),
  matrix: icon(svg`<rect x="4" y="4" width="16" height="16" rx="2.5"/><path d="M4 9.3h16M4 14.7h16M9.3 4v16M14.7 4v16" opacity=".6"/><path d="M4.5 4.5h4.3v4.3H4.5zM9.8 9.8h4.4v4.4H9.8zM15.2 15.2h4.3v4.3h-4.3z" fill="currentColor" stroke="none"/>`),
  list: icon(svg`<path d="M8 6h12M8 12h12M8 18h12M4 6h.01M4 12h.01M4 18h.01" stroke-width="2"/>`),
  ruler: icon(svg`<path d="M3.5 8.5h17v7h-17z"/><path d="M7 8.5v3M10.4 8.5v3.6M13.8 8.5v3M17.2 8.5v3"/>`),
  route: icon(svg`<circle cx="5.5" cy="18.5" r="2"/><circle cx="18.5" cy="5.5" r="2"/><path d="M7.5 18.5H14a3.5 3.5 0 0 0 0-7h-4a3.5 3.5 0 0 1 0-6h6.5"/>`),
  scans: icon(svg`<path d="M4 16V5h11"/><path d="M8.5 20.5 20 17.6 17.4 7.5" stroke-dasharray="2.6 3"/><circle cx="4" cy="16" r="1.5" fill="currentColor"/><circle cx="15" cy="5" r="1.5" fill="currentColor"/>`),
  gamepad: icon(svg`<path d="M7.5 7h9a4.5 4.5 0 0 1 4.4 3.6l.9 4.6a2.6 2.6 0 0 1-4.5 2.2L15.5 15h-7l-1.8 2.4a2.6 2.6 0 0 1-4.5-2.2l.9-4.6A4.5 4.5 0 0 1 7.5 7z"/><path d="M8 9.5v3M6.5 11h3M15.2 11h.01M17.5 11h.01" stroke-width="2"/>`),
  flag: icon(svg`<path d="M6 21V4M6 5c4-2.5 8 2.5 12.5 0v8.5C14 16 10 11 6 13.5"/>`),
  sliders: icon(svg`<path d="M4 7h9M17 7h3M4 17h3M11 17h9"/><circle cx="15" cy="7" r="2"/><circle cx="9" cy="17" r="2"/>`),
};
