// Moves, turns and reshapes a part of a drawing.

import type { Part, Point } from "./drawing.js";
import { cornersOf, distance, lineOf, minus, plus, turned } from "./outline.js";
import { tidy } from "./snap.js";

/** The least thickness of anything, m. */
const LEAST = 0.02;

/** A handle to drag: a corner, a point of a path, a radius, or the turn of the whole. */
export interface Handle { readonly at: Point; readonly what: "corner" | "radius" | "turn"; readonly index: number }

const tidyPoint = ([x, y]: Point): Point => [tidy(x), tidy(y)];

/** Maps every point of a part; a part with an angle is turned by `turn`, rad. */
function mapped(part: Part, to: (point: Point) => Point, turn: number): Part {
  const put = (point: Point): Point => tidyPoint(to(point));
  switch (part.kind) {
    case "door": return { kind: "door", value: { ...part.value, from: put(part.value.from), to: put(part.value.to) } };
    case "mover": return { kind: "mover", value: { ...part.value, waypoints: part.value.waypoints.map(put) } };
    case "start": {
      const [x, y] = put([part.value.x, part.value.y]);
      return { kind: "start", value: { x, y, heading: wrapped((part.value.heading ?? 0) + turn) } };
    }
    case "goal": {
      const [x, y] = put([part.value.x, part.value.y]);
      return { kind: "goal", value: { x, y } };
    }
    case "obstacle": {
      const { value } = part;
      if (value.shape === "circle") return { kind: "obstacle", value: { ...value, centre: put(value.centre) } };
      if (value.shape === "rectangle") return { kind: "obstacle", value: { ...value, centre: put(value.centre), angle: wrapped((value.angle ?? 0) + turn) } };
      return { kind: "obstacle", value: { ...value, points: value.points.map(put) } };
    }
  }
}

function wrapped(angle: number): number {
  return tidyAngle(Math.atan2(Math.sin(angle), Math.cos(angle)));
}

const tidyAngle = (angle: number): number => Math.round(angle * 1e6) / 1e6 + 0;

export function moved(part: Part, by: Point): Part {
  return mapped(part, (point) => plus(point, by), 0);
}

/** Turned about its middle; +90° takes the x axis to the y axis. */
export function rotated(part: Part, angle: number): Part {
  const middle = middleOf(part);
  return mapped(part, (point) => plus(middle, turned(minus(point, middle), angle)), angle);
}

/** The middle of the box around its points. */
export function middleOf(part: Part): Point {
  const { points } = lineOf(part);
  const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
  return [(Math.min(...xs) + Math.max(...xs)) / 2, (Math.min(...ys) + Math.max(...ys)) / 2];
}

/** `arm`: distance of the turning handle from the part, m. */
export function handlesOf(part: Part, arm: number): Handle[] {
  const corners = lineOf(part).points.map((at, index): Handle => ({ at, what: "corner", index }));
  switch (part.kind) {
    case "start": {
      const { x, y, heading = 0 } = part.value;
      return [{ at: plus([x, y], turned([2 * arm, 0], heading)), what: "turn", index: 0 }];
    }
    case "goal": return [];
    case "obstacle": {
      const { value } = part;
      if (value.shape === "circle") return [{ at: plus(value.centre, [value.radius, 0]), what: "radius", index: 0 }];
      if (value.shape !== "rectangle") return corners;
      const top = plus(value.centre, turned([0, value.size[1] / 2 + arm], value.angle ?? 0));
      return [...corners, { at: top, what: "turn", index: 0 }];
    }
    default: return corners;
  }
}

/** The part with a handle dragged to a place. `step`: turns snap to multiples, rad; 0: no snap. */
export function dragged(part: Part, handle: Handle, to: Point, step: number): Part {
  const angleTo = (centre: Point): number => {
    const angle = Math.atan2(to[1] - centre[1], to[0] - centre[0]);
    return step > 0 ? Math.round(angle / step) * step : angle;
  };
  const put = (points: readonly Point[]): Point[] => points.map((point, at) => (at === handle.index ? tidyPoint(to) : point));
  switch (part.kind) {
    case "start": return { kind: "start", value: { ...part.value, heading: wrapped(angleTo([part.value.x, part.value.y])) } };
    case "goal": return part;
    case "door": {
      const [from, end] = put([part.value.from, part.value.to]) as [Point, Point];
      return { kind: "door", value: { ...part.value, from, to: end } };
    }
    case "mover": return { kind: "mover", value: { ...part.value, waypoints: put(part.value.waypoints) } };
    case "obstacle": {
      const { value } = part;
      if (value.shape === "circle") return { kind: "obstacle", value: { ...value, radius: tidy(Math.max(distance(value.centre, to), LEAST)) } };
      if (value.shape !== "rectangle") return { kind: "obstacle", value: { ...value, points: put(value.points) } };
      if (handle.what === "turn") return { kind: "obstacle", value: { ...value, angle: wrapped(angleTo(value.centre) - Math.PI / 2) } };
      // The opposite corner stays where it is.
      const across = cornersOf(value)[(handle.index + 2) % 4] as Point;
      const angle = value.angle ?? 0;
      const [width, height] = turned(minus(to, across), -angle);
      return { kind: "obstacle", value: { ...value, centre: tidyPoint([(to[0] + across[0]) / 2, (to[1] + across[1]) / 2]), size: [tidy(Math.max(Math.abs(width), LEAST)), tidy(Math.max(Math.abs(height), LEAST))] } };
    }
  }
}
