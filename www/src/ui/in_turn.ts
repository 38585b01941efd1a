// What a frame of a run makes drawn again takes turns, some for a picture: all at once, pictures
// with a frame would take several times as long as the others.

/** What is done for a picture; all of a frame is done before the next one. */
const MOST = 3;

interface Turn { readonly act: () => void; readonly weight: number }

const waiting = new Map<unknown, Turn>();

/** Acts within the next pictures; once, however often that is asked for in the name of `who`.
    `weight`: how many texts that change it amounts to. */
export function inTurn(who: unknown, act: () => void, weight = 1): void {
  if (waiting.size === 0) requestAnimationFrame(next);
  waiting.set(who, { act, weight });
}

function next(): void {
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
