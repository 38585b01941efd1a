// The first visit: what SLAM is, in four steps, told by a run that is under way.

import type { Client } from "./client.js";
import type { Store } from "./store.js";
import { isFirstVisit, noteVisit } from "./visit.js";

/** A ring is where doubt is seen to grow, all the way round, and to shrink at once. */
const RUN = { world: "loop", sensor: "lidar", method: "scan-matching", mode: "explore", cycle: false, seed: 7 } as const;
/** So that the ring is closed within a minute. */
export const SPEED = 10;

/** The ellipse of a robot that is known to a tenth of a metre is seen at so many pixels a metre. */
const NEAR = 200;

/** What the tour is about, step by step. */
export const STEPS = ["unknown", "wheels", "doubt", "loop"] as const;
export type TourStep = (typeof STEPS)[number];

/** On a first visit to a simulation the tour begins with a run of its own; whether it does. */
export function greet(store: Store, client: Client): boolean {
  if (!isFirstVisit()) return false;
  begin(store, client);
  return true;
}

/** Begins with the first step, and a run in which all of them are seen. */
export function begin(store: Store, client: Client): void {
  noteVisit();
  // The answer is not given away, and nothing is shown that the steps do not speak of.
  store.setLayers({ truth: false, wheels: false, trails: false, frontiers: false, path: false, closures: false });
  client.setSpeed(SPEED);
  client.start(RUN);
  store.set("tour", { tour: STEPS[0] });
}

/** Whether the run that is shown, or being loaded, is the one that the tour began. */
export function isOwnRun({ source, setup, loading }: Store): boolean {
  return loading === RUN.world || (source === "sim" && setup.world === RUN.world && setup.worldJson === null);
}

/** To a step, or out of the tour; `isNear`: the robot is followed, so that its doubt is seen. */
export function go(store: Store, step: TourStep | null, isNear = step === "doubt"): void {
  const patch = step === null ? { frontiers: true, path: true, closures: true, trails: true } : step === "wheels" ? { wheels: true, trails: true } : {};
  store.setLayers(patch);
  store.set("tour", { tour: step });
  dispatchEvent(new CustomEvent("show-robot", { detail: isNear ? NEAR : null }));
}
