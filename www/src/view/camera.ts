// Map metres to canvas pixels and back: the only place that flips y.

import { turnBetween } from "../angle.js";
import type { Pencil } from "./painter.js";

export interface Box {
  minX: number;
  minY: number;
  maxX: number;
  maxY: number;
}

/** The smallest box that contains both. */
export function union(a: Box | null, b: Box): Box {
  if (a === null) return b;
  return { minX: Math.min(a.minX, b.minX), minY: Math.min(a.minY, b.minY), maxX: Math.max(a.maxX, b.maxX), maxY: Math.max(a.maxY, b.maxY) };
}

/** Whether the box with these corners, in any order, lies outside of `box`, by more than `reach`
    along an axis. */
export function isOutside({ minX, minY, maxX, maxY }: Box, x1: number, y1: number, x2: number, y2: number, reach = 0): boolean {
  return (x1 < minX - reach && x2 < minX - reach) || (x1 > maxX + reach && x2 > maxX + reach) || (y1 < minY - reach && y2 < minY - reach) || (y1 > maxY + reach && y2 > maxY + reach);
}

/** Scale of the view that follows the robot, pixels per metre. */
export const NEAR = 80;

export class Camera {
  /** Map point in the middle of the free part of the canvas, m. */
  x = 0;
  y = 0;
  /** CSS pixels per metre. */
  scale = 48;
  /** The rotation of the map on the screen, rad: +90° makes the map's x axis point up. */
  angle = 0;
  /** Size of the canvas, CSS pixels. */
  width = 1;
  height = 1;
  /** Device pixels per CSS pixel. */
  ratio = 1;
  /** CSS pixels on each side that panels cover. */
  inset = { top: 0, right: 0, bottom: 0, left: 0 };

  static readonly MIN_SCALE = 2;
  static readonly MAX_SCALE = 800;

  toScreen(x: number, y: number): [number, number] {
    const [cos, sin] = [Math.cos(this.angle), Math.sin(this.angle)];
    const [dx, dy] = [x - this.x, y - this.y];
    return [this.#middleX + (cos * dx - sin * dy) * this.scale, this.#middleY - (sin * dx + cos * dy) * this.scale];
  }

  toMap(screenX: number, screenY: number): [number, number] {
    const [dx, dy] = this.#across(screenX - this.#middleX, screenY - this.#middleY);
    return [this.x + dx, this.y + dy];
  }

  /** The displacement in the map, m, that corresponds to so many CSS pixels on the screen. */
  #across(screenX: number, screenY: number): [number, number] {
    const [cos, sin] = [Math.cos(this.angle) / this.scale, Math.sin(this.angle) / this.scale];
    return [cos * screenX - sin * screenY, -sin * screenX - cos * screenY];
  }

  /** Map metres to device pixels, in the form of a 2D context. */
  get transform(): readonly [number, number, number, number, number, number] {
    const k = this.scale * this.ratio;
    const [x, y] = this.toScreen(0, 0);
    const [cos, sin] = [k * Math.cos(this.angle), k * Math.sin(this.angle)];
    return [cos, -sin, -sin, -cos, x * this.ratio, y * this.ratio];
  }

  /** Makes the context draw in metres, y up; `px` gives widths. */
  applyTo(context: Pick<Pencil, "setTransform">): void {
    context.setTransform(...this.transform);
  }

  /** The length in metres of `n` CSS pixels. */
  px(n: number): number {
    return n / this.scale;
  }

  panBy(screenX: number, screenY: number): void {
    const [x, y] = this.#across(screenX, screenY);
    this.x -= x;
    this.y -= y;
  }

  /** Turns the map on the screen so that the map point under the given pixel stays there. */
  turnAt(angle: number, screenX: number, screenY: number): void {
    const [x, y] = this.toMap(screenX, screenY);
    this.angle = turnBetween(this.angle + angle, 0);
    const [newX, newY] = this.toMap(screenX, screenY);
    this.x += x - newX;
    this.y += y - newY;
  }

  /** Zooms so that the map point under the given pixel stays there. */
  zoomAt(factor: number, screenX: number, screenY: number): void {
    const [x, y] = this.toMap(screenX, screenY);
    this.scale = clamp(this.scale * factor, Camera.MIN_SCALE, Camera.MAX_SCALE);
    const [newX, newY] = this.toMap(screenX, screenY);
    this.x += x - newX;
    this.y += y - newY;
  }

  /** The view that shows all of `box`, with a scale of at most `maxScale`. */
  fitted(box: Box, maxScale = 90): { x: number; y: number; scale: number } {
    const width = Math.max(this.width - this.inset.left - this.inset.right, 40);
    const height = Math.max(this.height - this.inset.top - this.inset.bottom, 40);
    const [cos, sin] = [Math.abs(Math.cos(this.angle)), Math.abs(Math.sin(this.angle))];
    const [across, up] = [box.maxX - box.minX, box.maxY - box.minY];
    const scale = Math.min(width / Math.max(cos * across + sin * up, 0.5), height / Math.max(sin * across + cos * up, 0.5));
    return {
      x: (box.minX + box.maxX) / 2,
      y: (box.minY + box.maxY) / 2,
      scale: clamp(scale * 0.95, Camera.MIN_SCALE, maxScale),
    };
  }

  /** The axis-aligned bounding box, in the map, of what is visible. */
  get visible(): Box {
    const corners = [this.toMap(0, 0), this.toMap(this.width, 0), this.toMap(0, this.height), this.toMap(this.width, this.height)];
    const [xs, ys] = [corners.map(([x]) => x), corners.map(([, y]) => y)];
    return { minX: Math.min(...xs), minY: Math.min(...ys), maxX: Math.max(...xs), maxY: Math.max(...ys) };
  }

  get #middleX(): number {
    return (this.inset.left + this.width - this.inset.right) / 2;
  }

  get #middleY(): number {
    return (this.inset.top + this.height - this.inset.bottom) / 2;
  }
}

export function clamp(value: number, low: number, high: number): number {
  return Math.min(Math.max(value, low), high);
}
