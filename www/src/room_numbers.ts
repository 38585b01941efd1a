// Numbers of rooms that stay the same while the map grows, although the list of rooms is sorted by
// size.

import type { Rooms } from "./protocol/module.js";
import { roomAt } from "./view/things.js";

type Regions = Pick<Rooms, "regions">;

/** The number of each room: that of the earlier room whose middle lies in it, or else the first
    free one. */
export function numbered(now: Regions, before: Regions | null, numbers: readonly number[]): number[] {
  const found = now.regions.map(() => 0);
  const taken = new Set<number>();
  // A room merged from several keeps the number of the largest, which comes first.
  before?.regions.forEach(({ middle }, old) => {
    const [room, number] = [roomAt(now, ...middle), numbers[old]];
    if (room === null || number === undefined || found[room] !== 0) return;
    found[room] = number;
    taken.add(number);
  });
  let next = 1;
  return found.map((number) => {
    if (number !== 0) return number;
    while (taken.has(next)) next += 1;
    taken.add(next);
    return next;
  });
}
