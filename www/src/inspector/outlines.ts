// Outlines of what is inspected, map frame, m.

import type { Outline } from "../view/layers/layer.js";
import { ellipseOf } from "../view/layers/robot.js";

/** Sides of a circle that looks round. */
const SIDES = 48;

export function segment(x1: number, y1: number, x2: number, y2: number): Outline {
  return [[[x1, y1], [x2, y2]]];
}

export function square(x: number, y: number, side: number): Outline {
  const h = side / 2;
  return [[[x - h, y - h], [x + h, y - h], [x + h, y + h], [x - h, y + h], [x - h, y - h]]];
}

export function ring(x: number, y: number, radius: number): Outline {
  return ellipse(x, y, { major: radius, minor: radius, angle: 0 });
}

export function ellipse(x: number, y: number, { major, minor, angle }: ReturnType<typeof ellipseOf>): Outline {
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  return [Array.from({ length: SIDES + 1 }, (_, i): [number, number] => {
    const turn = (2 * Math.PI * i) / SIDES;
    const [u, v] = [major * Math.cos(turn), minor * Math.sin(turn)];
    return [x + cos * u - sin * v, y + sin * u + cos * v];
  })];
}
