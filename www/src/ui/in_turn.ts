// Spreads the redrawing after a frame of a run over several pictures: all at once, such pictures
// would take several times as long as the others.

import { takePicture } from "../long_work.js";

/** Most weight of the work in one picture; all work of a frame is done before the next one. */
const MOST = 3;

interface Turn { readonly act: () => void; readonly weight: number }

const waiting = new Map<unknown, Turn>();
/** The last picture had other long work to do. */
let isOwed = false;

/** Calls `act` within the next pictures, and only once for each `who`, however often requested.
    `weight`: how many text updates it costs. */
export function inTurn(who: unknown, act: () => void, weight = 1): void {
  if (waiting.size === 0) requestAnimationFrame(next);
  waiting.set(who, { act, weight });
}

function next(now: number): void {
  isOwed = !takePicture(now, isOwed);
  if (isOwed) {
    requestAnimationFrame(next);
    return;
  }
  const turns: Turn[] = [];
  let sum = 0;
  for (const [who, turn] of waiting) {
    if (turns.length > 0 && sum + turn.weight > MOST) break;
    sum += turn.weight;
    turns.push(turn);
    waiting.delete(who);
  }
  if (waiting.size > 0) requestAnimationFrame(next);
  for (const { act } of turns) act();
}
