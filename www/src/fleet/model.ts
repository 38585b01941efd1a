// All robots behind the router, as the bridge tells of them; what is urgent; who shares a map.

import type { DisarmReasonName } from "../protocol/module.js";

/** A slot of /fleet.json. Times are µs of the bridge's clock, when it was heard. */
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

/** Of a robot that only drove: what changed of its slot. */
export type Moved = Pick<Robot, "name" | "heard" | "pose" | "pose_heard">;

export interface Changes {
  readonly revision: number;
  readonly now: number;
  readonly left_out: number;
  readonly connected: boolean;
  readonly robots: readonly Robot[];
  readonly moved: readonly Moved[];
}

/** How a robot does, the most urgent first. */
export const STATES = ["emergency", "away", "silent", "alert", "lost", "driving", "standing"] as const;
export type State = (typeof STATES)[number];

/** A robot says something each second; after so long without, s, something is wrong. */
const SILENT = 3;
/** An alert is urgent for so long, s; it is shown until there is another. */
const FRESH = 60;
const MICROS = 1e6;
/** Reasons that somebody has to look after, whoever is there. */
const TROUBLE: ReadonlySet<DisarmReasonName> = new Set(["link", "silence", "bumper", "battery", "stall", "runaway", "geofence"]);

/** Whether somebody has to look after a robot that was disarmed so. The link also comes up when a
    bridge starts, which nobody drove meanwhile: of it only who was driving has to know. */
const isTrouble = ({ armed, reason, driver }: NonNullable<Robot["safety"]>): boolean => !armed && TROUBLE.has(reason) && (reason !== "link" || driver !== "");

/** Robots whose poses are drawn together. */
export interface Frame {
  /** Name of the map's file; null where the map is the robot's alone. */
  readonly file: string | null;
  readonly key: string;
  readonly robots: readonly Robot[];
}

export class Fleet {
  readonly robots = new Map<string, Robot>();
  revision = 0;
  leftOut = 0;
  connected = false;
  /** The bridge's clock less this page's, µs. */
  #ahead = 0;

  take(changes: Changes, now: number): void {
    // The bridge was started again, and knows nothing of who was there before.
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

  /** Those whose name holds `part`, the most urgent first. */
  sorted(part: string, now: number): { robot: Robot; state: State }[] {
    const wanted = part.trim().toLocaleLowerCase();
    return [...this.robots.values()]
      .filter((robot) => robot.name.toLocaleLowerCase().includes(wanted))
      .map((robot) => ({ robot, state: this.state(robot, now) }))
      .sort((a, b) => STATES.indexOf(a.state) - STATES.indexOf(b.state) || a.robot.name.localeCompare(b.robot.name, undefined, { numeric: true }));
  }

  /** Who shares a map, the most robots first. */
  frames(): Frame[] {
    const frames = new Map<string, { file: string | null; key: string; robots: Robot[] }>();
    for (const robot of this.robots.values()) {
      if (!robot.pose) continue;
      // In a map of its own: none is kept, or it is not known where the robot lies in that.
      const file = robot.map_file && robot.pose_state !== "unplaced" ? robot.map_file : null;
      const key = file === null ? `robot:${robot.name}` : `file:${file}`;
      const frame = frames.get(key) ?? { file, key, robots: [] };
      frame.robots.push(robot);
      frames.set(key, frame);
    }
    return [...frames.values()].sort((a, b) => b.robots.length - a.robots.length || (a.key < b.key ? -1 : 1));
  }
}
