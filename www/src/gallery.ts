// Instructive experiments: each is a run that is set up to show one thing.

import type { Client } from "./client.js";
import type { Setup } from "./protocol/module.js";
import type { Store, Tab } from "./store.js";
import { NEAR } from "./view/camera.js";
import type { LayerName } from "./view/scene.js";

export interface Exhibit {
  readonly name: string;
  readonly title: string;
  /** Its subject, in one line. */
  readonly about: string;
  /** What to watch, and why it happens. */
  readonly watch: string;
  /** What to try next. */
  readonly then: string;
  readonly setup: Pick<Setup, "world" | "sensor" | "method" | "seed"> & Partial<Pick<Setup, "settings" | "cycle">>;
  readonly speed: number;
  readonly layers?: Partial<Record<LayerName, boolean>>;
  readonly tab?: Tab;
  /** Whether it offers to carry its robot elsewhere. */
  readonly kidnaps?: boolean;
  /** Whether the view follows the robot. */
  readonly follow?: boolean;
}

export const EXHIBITS: readonly Exhibit[] = [
  {
    name: "loop", title: "A loop closes", about: "What was far away for the map is found to be here",
    setup: { world: "loop", sensor: "lidar", method: "scan-matching", seed: 7 }, speed: 10, layers: { truth: false, graph: true, closures: true, wheels: false },
    watch: "Circles are the pieces that the map is made of, each joined to the next. All round the ring errors add up. Once the robot sees again where it began, a green line joins both ends, and the whole chain gives way a little.",
    then: "A click on a green line says how far off the ends were, and why the loop was believed.",
  },
  {
    name: "wheels", title: "Wheels alone", about: "The same drive without looking",
    setup: { world: "office", sensor: "lidar", method: "odometry", seed: 7 }, speed: 10, layers: { truth: true, trails: true },
    watch: "The pose comes from the wheels only, and each scan is drawn where they say. A slip of a degree at one turn moves all that is drawn after it: walls stand twice, the room turns about itself, and the robot loses its way.",
    then: "Choose the line filter under Method: the same seed gives the same building, and the same wheels.",
  },
  {
    name: "corridor", title: "A corridor without a feature", about: "Sure across, unsure along",
    setup: { world: "corridor", sensor: "lidar", method: "scan-matching", seed: 7 }, speed: 4, layers: { truth: true, robot: true }, follow: true,
    watch: "The walls say exactly how far away they are, and nothing of how far along them the robot has come: there only the wheels count. So the ellipse grows along the corridor, and across it by the little that is not known of the heading, of which a long way makes much, until an end comes in sight.",
    then: "The registration lab (L) shows the same for two scans: it calls such a match degenerate, and names the direction.",
  },
  {
    name: "too-sure", title: "A filter that is too sure", about: "It takes for chance what is always the same",
    setup: { world: "loop", sensor: "lidar", method: "line-ekf", seed: 7, settings: { "ekf.consistency": 0, "ekf.prior_curvature": 0, "ekf.prior_turn": 0 } }, speed: 20, tab: "plots", layers: { truth: true },
    watch: "One track runs a little farther than the other, always. This filter takes every error of the wheels for chance, and linearises at ever newer estimates: it believes to know its heading better than it can. The error leaves the 3σ band, and at the end of the ring it does not know its own walls again.",
    then: "Under Settings, give back what straight drives bend by and what turns are wrong by, and restart: the same drive, and the band holds.",
  },
  {
    name: "kidnapped", title: "Kidnapped", about: "Carried off, and found again",
    setup: { world: "office", sensor: "lidar", method: "particle-localisation", seed: 7 }, kidnaps: true, speed: 2, layers: { hypotheses: true, priorMap: true, truth: true },
    watch: "The robot knows the building and where it stands. Press Kidnap: it is carried elsewhere and not told. For some scans nothing fits; then poses all over the building are tried, and as it drives those die out that see walls where there are none.",
    then: "Do it again in a room that looks like another: several places stay, until the robot looks round a corner.",
  },
  {
    name: "look-alikes", title: "Ten rooms, all alike", about: "Where am I, if everything looks the same?",
    setup: { world: "look-alikes", sensor: "lidar", method: "particle-localisation", seed: 7 }, kidnaps: true, speed: 2, layers: { hypotheses: true, priorMap: true, truth: true },
    watch: "Press Kidnap. Every one of the rooms explains what is seen, so there is a hypothesis in each, and the robot says that it is not sure. Only what differs decides; as long as nothing does it stays unsure, and what it draws meanwhile is worth nothing.",
    then: "By scan matching the same building is mapped without a map to start from: no room is taken for another.",
  },
  {
    name: "glass", title: "Glass and dark walls", about: "A lidar does not see all that stands there",
    setup: { world: "lab", sensor: "lidar", method: "line-ekf", seed: 7 }, speed: 2, layers: { truth: true },
    watch: "Light goes through glass but where it meets it squarely, and dark walls swallow it but from near. Look for true walls (dashed) that the map does not have, and for places behind glass that it has.",
    then: "Choose sonars as the sensor: they hear glass, and little else exactly.",
  },
  {
    name: "crowd", title: "In a crowd", about: "What moves must not become a wall",
    setup: { world: "crowd", sensor: "lidar", method: "scan-matching", seed: 7 }, speed: 2, layers: { tracks: true, truth: true },
    watch: "Ten people walk about. Each that was seen to move has a number, a velocity and an ellipse, and its points count neither for the pose nor for the map. It loses its number when it is out of sight for a while.",
    then: "Switch off Follow what moves, under Settings, and look for the traces that people leave.",
  },
  {
    name: "four-eyes", title: "Four eyes on a servo", about: "The least sensor that maps a building",
    setup: { world: "doors", sensor: "rangers", method: "line-ekf", seed: 7, cycle: true }, speed: 4, layers: { truth: true, found: true },
    watch: "Four infra-red rangers see as far as 1.5 m, and only while the robot stands. It scans, finds lines, compares them with those that it knows, plans one leg, drives it blindly, and stands again. The strip below says what each stage gave.",
    then: "Pause, and go stage by stage with the full stop key.",
  },
  {
    name: "echoes", title: "Sixteen echoes", about: "A cone says that something is near, not where",
    setup: { world: "arena", sensor: "sonar", method: "odometry", seed: 7 }, speed: 4, layers: { truth: true },
    watch: "Each sonar hears the nearest thing in a cone of 30°. Its arc is drawn all over; only where arcs of many places agree a wall stays. Corners are round, gaps narrow, and nothing tells the robot that its wheels slip.",
    then: "Compare with the lidar in the same room: one choice under Sensor.",
  },
  {
    name: "particles", title: "A map in every particle", about: "Many guesses, each with a map of its own",
    setup: { world: "office", sensor: "lidar", method: "grid-particles", seed: 7 }, speed: 4, layers: { hypotheses: true, truth: false },
    watch: "Each particle is a whole history: a way, and the map that follows from it. Those whose map agrees with what is seen are copied, others die. What is drawn is the map of the likeliest; at a closed loop it may change at once.",
    then: "Fewer particles, under Settings, are faster, and may have lost the right one when it is needed.",
  },
  {
    name: "not-fooled", title: "The same, or only alike?", about: "How much must speak for a place seen again",
    setup: { world: "look-alikes", sensor: "lidar", method: "scan-matching", seed: 7 }, speed: 20, layers: { truth: true, closures: true, graph: true },
    watch: "Ten rooms look alike, and each could be taken for any other. Green lines join places that were proved to be one: they stay within a room and its corridor. Of what is only alike another room would have fitted as well, or the way between would have had to err by more than it does. One room laid on another would bend the whole map.",
    then: "A click on a green line says what spoke for it, and how much was asked for.",
  },
];

/** The part of an experiment that is kept while it runs. */
export type Shown = Pick<Exhibit, "name" | "title" | "watch" | "then" | "setup" | "kidnaps">;

const ADDRESS = "#experiment=";

/** The address of an experiment, to be appended to that of the page. */
export const addressOf = ({ name }: Pick<Exhibit, "name">): string => ADDRESS + name;

/** The experiment at an address: `null` if it names none, the name itself if there is no such
    experiment. */
export function exhibitAt(hash: string): Exhibit | string | null {
  if (!hash.startsWith(ADDRESS)) return null;
  const name = hash.slice(ADDRESS.length);
  return EXHIBITS.find((each) => each.name === name) ?? name;
}

/** Whether the run that is shown or being loaded is that of an experiment. */
export function isOf({ setup: { world, method, seed } }: Shown, store: Store): boolean {
  const { setup } = store;
  if (store.loading !== "") return store.loading === world;
  return store.source === "sim" && setup.worldJson === null && setup.world === world && setup.method === method && setup.seed === seed;
}

/** Begins an experiment. */
export function exhibit(store: Store, client: Client, { name, title, watch, then, setup, kidnaps = false, speed, layers = {}, tab, follow = false }: Exhibit): void {
  const { world, sensor, method, seed, settings = {}, cycle = false } = setup;
  store.setLayers(layers);
  if (tab !== undefined) store.set("tab", { tab });
  client.setSpeed(speed);
  client.start({ world, sensor, method, seed, settings, cycle, worldJson: null, mode: "explore", calibration: null, priorMap: null });
  dispatchEvent(new CustomEvent("show-robot", { detail: follow ? NEAR : null }));
  store.set("exhibit", { exhibit: { name, title, watch, then, setup, kidnaps } });
}
