// Numbers of rooms that stay the same while the map grows, though the list of rooms is sorted by
// size.

import { REGION, REGION_STRIDE, type Rooms } from "./protocol/module.js";
import { roomAt } from "./view/layers/rooms.js";

/** What identifies rooms from one map to the next. */
type Areas = Pick<Rooms, "regions" | "corners" | "rings">;

/** The number of each room: that of the room before that had its middle in it, else the first that
    is free. */
export function numbered(now: Areas, before: Areas | null, numbers: readonly number[]): number[] {
  const count = now.regions.length / REGION_STRIDE;
  const found = new Array<number>(count).fill(0);
  const taken = new Set<number>();
  // A room that has swallowed others keeps the number of the largest, which comes first.
  numbers.forEach((number, old) => {
    const at = (place: number): number => before?.regions[old * REGION_STRIDE + place] ?? NaN;
    const room = roomAt(now, at(REGION.x), at(REGION.y));
    if (room === null || found[room] !== 0) return;
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
