// What the robot is about to do, in words a visitor understands.

import type { Mode } from "../protocol/module.js";

const WINDS = ["east", "north-east", "north", "north-west", "west", "south-west", "south", "south-east"] as const;

/** `activity` is the pilot's own word: idle, driving, homeward, looking. North is up on the map. */
export function errand(mode: Mode, activity: string, x: number, y: number, goalX: number, goalY: number): string {
  if (mode === "manual") return "";
  if (activity === "looking") return "stands and looks around";
  if (!Number.isFinite(goalX)) return mode === "explore" ? "looks for the next frontier" : "plans a way";
  const [dx, dy] = [goalX - x, goalY - y];
  const wind = WINDS[Math.round(Math.atan2(dy, dx) / (Math.PI / 4) + 8) % 8] ?? "";
  const way = `${Math.hypot(dx, dy).toFixed(1)} m to the ${wind}`;
  if (activity === "homeward") return `all is explored, drives home, ${way}`;
  return mode === "explore" ? `heads for a frontier ${way}` : way;
}
