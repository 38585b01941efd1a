// The tour of a first visit: what SLAM is, in four steps, shown on a live run.

import type { Client } from "./client.js";
import type { Store } from "./store.js";
import { isFirstVisit, noteVisit } from "./visit.js";

/** In a ring the uncertainty visibly grows all the way round, and shrinks at once. */
const RUN = { world: "loop", sensor: "lidar", method: "scan-matching", mode: "explore", cycle: false, seed: 7 } as const;
/** Fast enough to close the ring within a minute. */
export const SPEED = 10;

/** At so many pixels per metre the ellipse of a position known to a tenth of a metre is visible. */
const NEAR = 200;

/** The subjects of the tour, step by step. */
export const STEPS = ["unknown", "wheels", "doubt", "loop"] as const;
export type TourStep = (typeof STEPS)[number];

/** On a first visit to a simulation, begins the tour with a run of its own. Returns whether it
    does. */
export function greet(store: Store, client: Client): boolean {
  if (!isFirstVisit()) return false;
  begin(store, client);
  return true;
}

/** Begins with the first step, and a run that shows all of them. */
export function begin(store: Store, client: Client): void {
  noteVisit();
  // The answer is not given away, and nothing is shown that the steps do not explain.
  store.setLayers({ truth: false, wheels: false, trails: false, frontiers: false, path: false, closures: false });
  client.setSpeed(SPEED);
  client.start(RUN);
  store.set("tour", { tour: STEPS[0] });
}

/** Whether the run that is shown or being loaded is the one that the tour began. */
export function isOwnRun({ source, setup, loading }: Store): boolean {
  return loading === RUN.world || (source === "sim" && setup.world === RUN.world && setup.worldJson === null);
}

/** Goes to a step, or ends the tour; `isNear`: the view follows the robot, so that its uncertainty
    is visible. */
export function go(store: Store, step: TourStep | null, isNear = step === "doubt"): void {
  const patch = step === null ? { frontiers: true, path: true, closures: true, trails: true } : step === "wheels" ? { wheels: true, trails: true } : {};
  store.setLayers(patch);
  store.set("tour", { tour: step });
  dispatchEvent(new CustomEvent("show-robot", { detail: isNear ? NEAR : null }));
}
