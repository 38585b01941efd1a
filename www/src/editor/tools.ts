// The tools of the editor: what each makes of the points placed with it.

import { t } from "../words.js";
import { tidy } from "./snap.js";
import type { Material, Part, Point } from "./drawing.js";
import { distance } from "./outline.js";

export type ToolName = "select" | "wall" | "glass" | "box" | "post" | "door" | "person" | "start" | "goal";

export interface Tool {
  readonly title: string;
  readonly key: string;
  /** Instructions for pointer users. */
  readonly words: string;
  /** How many points it takes; with "many", the person ends the draft. */
  readonly takes: 0 | 1 | 2 | "many";
}

export const TOOLS: Readonly<Record<ToolName, Tool>> = {
  select: { title: "Select", key: "V", words: "Press something to choose it; drag it, or its handles.", takes: 0 },
  wall: { title: "Wall", key: "W", words: "Set corner after corner. On the last one again, or Enter: done. On the first: a closed room.", takes: "many" },
  glass: { title: "Glass", key: "L", words: "A wall of glass: set corner after corner, as of a wall. Most beams go through it.", takes: "many" },
  box: { title: "Box", key: "B", words: "Drag from corner to corner.", takes: 2 },
  post: { title: "Post", key: "O", words: "Drag from the middle outwards.", takes: 2 },
  door: { title: "Door", key: "D", words: "Drag from one side of the gap to the other.", takes: 2 },
  person: { title: "Person", key: "P", words: "Set the places between which somebody walks. On the last one again, or Enter: done.", takes: "many" },
  start: { title: "Start", key: "S", words: "Set where the robot starts; drag to where it looks.", takes: 2 },
  goal: { title: "Goal", key: "G", words: "Set where the robot should go.", takes: 1 },
};

/** Default speed, m/s, and radius, m, of a person. */
const PERSON = { speed: 0.5, radius: 0.2 } as const;

export interface Draft { readonly tool: ToolName; readonly points: readonly Point[] }

/** The part that a draft makes; null while its points make none. */
export function made({ tool, points }: Draft, material: Material, closed: boolean): Part | null {
  const [a, b] = points;
  const surface = tool === "glass" ? "glass" : material;
  const of = surface === "opaque" ? {} : { material: surface };
  switch (tool) {
    case "select": return null;
    case "wall":
    case "glass": {
      if (points.length < 2) return null;
      return { kind: "obstacle", value: { shape: "polyline", points, ...(closed && points.length > 2 ? { closed } : {}), ...of } };
    }
    case "box": {
      if (!a || !b || a[0] === b[0] || a[1] === b[1]) return null;
      return { kind: "obstacle", value: { shape: "rectangle", centre: [tidy((a[0] + b[0]) / 2), tidy((a[1] + b[1]) / 2)], size: [tidy(Math.abs(b[0] - a[0])), tidy(Math.abs(b[1] - a[1]))], angle: 0, ...of } };
    }
    case "post": return a && b && distance(a, b) > 0 ? { kind: "obstacle", value: { shape: "circle", centre: a, radius: tidy(distance(a, b)), ...of } } : null;
    case "door": return a && b && distance(a, b) > 0 ? { kind: "door", value: { from: a, to: b, open: false } } : null;
    case "person": return points.length > 0 ? { kind: "mover", value: { waypoints: points, closed, ...PERSON } } : null;
    case "start": return a ? { kind: "start", value: { x: a[0], y: a[1], heading: b && distance(a, b) > 0 ? Math.atan2(b[1] - a[1], b[0] - a[0]) : 0 } } : null;
    case "goal": return a ? { kind: "goal", value: { x: a[0], y: a[1] } } : null;
  }
}

/** The measures of a draft from its last point to the pointer: m and °. */
export function measure({ tool, points }: Draft, at: Point): string {
  const last = points.at(-1);
  if (!last || tool === "goal" || tool === "select") return "";
  const [dx, dy] = [at[0] - last[0], at[1] - last[1]];
  const length = Math.hypot(dx, dy);
  if (tool === "box") return `${Math.abs(dx).toFixed(2)} × ${Math.abs(dy).toFixed(2)} m`;
  if (tool === "post") return t`radius ${length.toFixed(2)} m`;
  const angle = `${degrees(Math.atan2(dy, dx))}°`;
  return tool === "start" ? angle : `${length.toFixed(2)} m, ${angle}`;
}

export function degrees(angle: number): string {
  return String(Math.round((angle * 1800) / Math.PI) / 10 + 0);
}

/** A part's name for people. */
export function called(part: Part): string {
  switch (part.kind) {
    case "door": return "Door";
    case "mover": return "Person";
    case "start": return "Start of the robot";
    case "goal": return "Goal";
    case "obstacle": {
      const { value } = part;
      const glass = value.material === "glass" ? "Glass " : value.material === "dark" ? "Dark " : "";
      const what = { polyline: "wall", polygon: "block", rectangle: "box", circle: "post" }[value.shape];
      return glass ? glass + what : what[0]?.toUpperCase() + what.slice(1);
    }
  }
}
