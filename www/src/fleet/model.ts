// All robots behind the router, as the bridge reports them; what is urgent; who shares a map.

import type { DisarmReasonName } from "../protocol/module.js";

/** A slot of /fleet.json. Times are when something was heard, µs of the bridge's clock. */
export interface Robot {
  readonly name: string;
  readonly here: boolean;
  readonly heard: number;
  /** x, y (m), heading (rad), in the map of this robot. */
  readonly pose: readonly [number, number, number] | null;
  readonly pose_state: "unknown" | "localised" | "ambiguous" | "lost" | "unplaced" | null;
  readonly pose_heard: number;
  readonly map_file: string | null;
  readonly volts: number | null;
  readonly safety: { readonly armed: boolean; readonly emergency: boolean; readonly reason: DisarmReasonName; readonly driver: string } | null;
  readonly alert: { readonly severity: "warning" | "error"; readonly text: string; readonly heard: number } | null;
  readonly page: string | null;
}

/** The changes in the slot of a robot that only drove. */
export type Moved = Pick<Robot, "name" | "heard" | "pose" | "pose_heard">;

export interface Changes {
  readonly revision: number;
  readonly now: number;
  readonly left_out: number;
  readonly connected: boolean;
  readonly robots: readonly Robot[];
  readonly moved: readonly Moved[];
}

/** The state of a robot, the most urgent first. */
export const STATES = ["emergency", "away", "silent", "alert", "lost", "driving", "standing"] as const;
export type State = (typeof STATES)[number];

/** A robot reports every second; after this long without a report, s, something is wrong. */
const SILENT = 3;
/** How long an alert is urgent, s; it is shown until there is another. */
const FRESH = 60;
const MICROS = 1e6;
/** Reasons that need attention, whoever is there. */
const TROUBLE: ReadonlySet<DisarmReasonName> = new Set(["link", "silence", "bumper", "battery", "stall", "runaway", "geofence"]);

/** Whether a robot disarmed in this way needs attention. The reason is "link" also when a bridge
    starts and nobody was driving; so a lost link counts only if there was a driver. */
const isTrouble = ({ armed, reason, driver }: NonNullable<Robot["safety"]>): boolean => !armed && TROUBLE.has(reason) && (reason !== "link" || driver !== "");

/** Robots whose poses are drawn together. */
export interface Frame {
  /** Name of the map's file; null if only this robot has the map. */
  readonly file: string | null;
  readonly key: string;
  readonly robots: readonly Robot[];
}

export class Fleet {
  readonly robots = new Map<string, Robot>();
  revision = 0;
  leftOut = 0;
  connected = false;
  /** The bridge's clock minus this page's, µs. */
  #ahead = 0;

  take(changes: Changes, now: number): void {
    // The bridge was restarted, and knows nothing of the robots of before.
    if (changes.revision < this.revision) this.robots.clear();
    for (const robot of changes.robots) this.robots.set(robot.name, robot);
    for (const moved of changes.moved) {
      const known = this.robots.get(moved.name);
      if (known) this.robots.set(moved.name, { ...known, ...moved });
    }
    this.revision = changes.revision;
    this.leftOut = changes.left_out;
    this.connected = changes.connected;
    this.#ahead = changes.now - now * 1000;
  }

  /** How long ago that was, s; `now` is this page's clock, ms. */
  age(heard: number, now: number): number {
    return Math.max(0, (now * 1000 + this.#ahead - heard) / MICROS);
  }

  state(robot: Robot, now: number): State {
    const { safety, alert } = robot;
    if (safety?.emergency) return "emergency";
    if (!robot.here) return "away";
    if (this.age(robot.heard, now) > SILENT) return "silent";
    if ((alert && this.age(alert.heard, now) < FRESH) || (safety && isTrouble(safety))) return "alert";
    if (robot.pose_state === "lost" || robot.pose_state === "ambiguous") return "lost";
    return safety?.armed ? "driving" : "standing";
  }

  /** Robots whose name contains `part`, the most urgent first. */
  sorted(part: string, now: number): { robot: Robot; state: State }[] {
    const wanted = part.trim().toLocaleLowerCase();
    return [...this.robots.values()]
      .filter((robot) => robot.name.toLocaleLowerCase().includes(wanted))
      .map((robot) => ({ robot, state: this.state(robot, now) }))
      .sort((a, b) => STATES.indexOf(a.state) - STATES.indexOf(b.state) || a.robot.name.localeCompare(b.robot.name, undefined, { numeric: true }));
  }

  /** Groups of robots that share a map, the largest first. */
  frames(): Frame[] {
    const frames = new Map<string, { file: string | null; key: string; robots: Robot[] }>();
    for (const robot of this.robots.values()) {
      if (!robot.pose) continue;
      // It has a map of its own if no map is kept, or if its place in that map is unknown.
      const file = robot.map_file && robot.pose_state !== "unplaced" ? robot.map_file : null;
      const key = file === null ? `robot:${robot.name}` : `file:${file}`;
      const frame = frames.get(key) ?? { file, key, robots: [] };
      frame.robots.push(robot);
      frames.set(key, frame);
    }
    return [...frames.values()].sort((a, b) => b.robots.length - a.robots.length || (a.key < b.key ? -1 : 1));
  }
}
