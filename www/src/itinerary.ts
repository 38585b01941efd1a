// Places that a robot is sent to when its run is over, so that what a story tells is surely seen.

import type { Client } from "./client.js";
import type { Status } from "./protocol/frame.js";

/** Map frame, m. */
export type Place = readonly [number, number];

/** In the ring, on both sides of where it begins: whichever way round the robot came, one of them
    lies beyond, in what it knows. */
export const ROUND_THE_RING: readonly Place[] = [[-1.4, 4], [4.5, 0]];

export class Itinerary {
  #next = 0;
  /** Sent, and not seen to be on its way yet. */
  #isSent = false;

  begin(): void {
    [this.#next, this.#isSent] = [0, false];
  }

  /** Sends the robot on, where its run is over. */
  follow(places: readonly Place[], status: Status, client: Client): void {
    const place = places[this.#next];
    if (!status.finished) this.#isSent = false;
    if (!status.finished || this.#isSent || !place) return;
    this.#next += 1;
    this.#isSent = true;
    client.goTo(...place);
  }
}
