// The layout of the map, its buttons and its read-out.

import { css } from "lit";

export const mapStyle = css`
  :host { position: absolute; inset: 0; overflow: hidden; background: var(--map-unknown); }
  canvas { position: absolute; inset: 0; width: 100%; height: 100%; display: block; transform-origin: 0 0; }
  #gl[hidden] { display: none; }
  #pad { position: absolute; inset: 0; cursor: crosshair; touch-action: none; outline-offset: -3px; }
  #pad.plain { cursor: grab; }
  #pad.wall, #pad.door { cursor: pointer; }
  #pad:active { cursor: grabbing; }
  #pad.draws, #pad.draws:active { cursor: crosshair; }
  #pad.inspects { cursor: help; }
  #cross { position: absolute; width: 25px; height: 25px; margin: -13px 0 0 -13px; pointer-events: none; color: var(--map-path); display: none; }
  #pad:focus-visible ~ #cross { display: block; }
  #tools { position: absolute; right: 14px; top: 14px; display: flex; flex-direction: column; gap: 6px; }
  #tools button { background: var(--glass); }
  #tools button[aria-pressed="true"] { background: var(--accent); color: var(--on-accent); border-color: transparent; }
  #foot { position: absolute; left: 16px; bottom: 14px; display: flex; flex-direction: column; gap: 8px; pointer-events: none; font: 500 12px/1.3 var(--mono); color: var(--ink); }
  #hover { background: var(--glass); border: 1px solid var(--line); border-radius: 6px; padding: 4px 8px; width: max-content; max-width: clamp(220px, 50cqw - 232px, 350px); }
  #scale { display: flex; align-items: end; gap: 8px; }
  #bar { height: 6px; border: 1.5px solid var(--ink); border-top: 0; opacity: .8; }
  /* Beside the dock there is no room for a long line but on very wide screens. */
  @container stage (max-width: 1700px) { #foot { bottom: var(--foot, 142px); } #hover { position: relative; bottom: var(--offer, 0px); } }
  /* The layers stand over its lower left. */
  @container stage (min-width: 824px) { :host(:not([told])) #hover { margin-left: 224px; } }
  @media (max-width: 760px) {
    #foot { bottom: auto; top: var(--foot-top, 12px); left: 12px; }
    :host([low]) #scale { display: none; }
    #hover { display: none; }
    #tools { right: 10px; top: calc(var(--card, 0px) + 10px); }
    :host([told]) #tools { display: none; }
  }
  /* On a wider page the header has it. */
  @media (min-width: 481px) { #tools .narrow { display: none; } }
  @media (pointer: coarse) and (max-width: 760px) {
    #tools .pinch { display: none; }
  }
`;
