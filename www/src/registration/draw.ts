// Draws two clouds, the pull on one of them and the search range of a method, on a canvas.

import { CORRESPONDENCE, CORRESPONDENCE_STRIDE } from "../protocol/module.js";
import { colourOf } from "../ui/plot_style.js";
import { type Box, type Camera } from "../view/camera.js";
import { place } from "./pose.js";
import type { Found, Pose } from "./protocol.js";

export interface Brush {
  readonly context: CanvasRenderingContext2D;
  readonly camera: Camera;
  readonly colours: Colours;
}

export interface Colours {
  readonly fixed: string;
  readonly moving: string;
  readonly pull: string;
  readonly width: string;
  readonly line: string;
  readonly ink: string;
  readonly warn: string;
}

/** Fraction of a scan's points at either end that may lie outside the view ... */
const FAR_PART = 0.04;
/** ... if they would make the view larger by more than this factor. */
const LARGER = 1.8;
/** Most points of a cloud at which the width is drawn. */
const MOST_WIDTHS = 26;

export function coloursOf(probe: HTMLElement): Colours {
  const of = (name: string): string => colourOf(probe, name);
  return { fixed: of("map-truth"), moving: of("map-estimate"), pull: of("map-walls"), width: of("map-path"), line: of("line"), ink: of("ink"), warn: of("warn") };
}

/** Sizes and clears a canvas, and returns a brush whose camera shows all of `box`. */
export function prepare(canvas: HTMLCanvasElement, box: Box, colours: Colours, camera: Camera): Brush | null {
  const context = canvas.getContext("2d");
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (!context || width === 0 || height === 0) return null;
  const ratio = Math.min(devicePixelRatio, 2);
  if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
  if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
  Object.assign(camera, { width, height, ratio });
  Object.assign(camera, camera.fitted(box, 400));
  context.resetTransform();
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.scale(ratio, ratio);
  return { context, camera, colours };
}

/** The box to show of a cloud at a pose. For a scan it is where most of it lies: a few long beams,
    through a door, would make everything else small. */
export function boxOf(points: Float64Array, pose: Pose, isScan: boolean): Box | null {
  if (points.length === 0) return null;
  const [xs, ys]: [number[], number[]] = [[], []];
  for (let i = 0; i + 1 < points.length; i += 2) {
    const [x, y] = place(pose, points[i] ?? 0, points[i + 1] ?? 0);
    xs.push(x);
    ys.push(y);
  }
  const [minX, maxX] = range(xs, isScan);
  const [minY, maxY] = range(ys, isScan);
  return { minX, minY, maxX, maxY };
}

function range(numbers: number[], isScan: boolean): [number, number] {
  numbers.sort((a, b) => a - b);
  const between = (cut: number): [number, number] => [numbers[cut] ?? 0, numbers[numbers.length - 1 - cut] ?? 0];
  const [all, most] = [between(0), between(isScan ? Math.floor(FAR_PART * numbers.length) : 0)];
  const [low, high] = all[1] - all[0] > LARGER * (most[1] - most[0]) ? most : all;
  const margin = isScan ? 0.06 * (high - low) : 0;
  return [low - margin, high + margin];
}

/** A line at every metre, or at every five metres if those would be too many. */
export function drawRules({ context, camera, colours }: Brush): void {
  const { minX, maxX, minY, maxY } = camera.visible;
  const step = camera.scale < 14 ? 5 : 1;
  context.strokeStyle = colours.line;
  context.globalAlpha = 0.6;
  context.lineWidth = 1;
  context.beginPath();
  for (let x = Math.ceil(minX / step) * step; x <= maxX; x += step) line(context, camera, [x, minY], [x, maxY]);
  for (let y = Math.ceil(minY / step) * step; y <= maxY; y += step) line(context, camera, [minX, y], [maxX, y]);
  context.stroke();
  context.globalAlpha = 1;
}

export function drawCloud({ context, camera }: Brush, points: Float64Array, pose: Pose, colour: string, size: number): void {
  context.fillStyle = colour;
  context.beginPath();
  for (let i = 0; i + 1 < points.length; i += 2) {
    const [x, y] = camera.toScreen(...place(pose, points[i] ?? 0, points[i + 1] ?? 0));
    context.moveTo(x + size, y);
    context.arc(x, y, size, 0, 2 * Math.PI);
  }
  context.fill();
}

/** Lines from points to their targets; the less weight, the fainter. */
export function drawPulls({ context, camera, colours }: Brush, rows: Float32Array): void {
  context.strokeStyle = colours.pull;
  context.lineWidth = 1.2;
  // Few shades, because each is one path.
  for (const [low, high] of [[0, 0.25], [0.25, 0.5], [0.5, 0.75], [0.75, 1.01]] as const) {
    context.globalAlpha = 0.15 + 0.7 * low;
    context.beginPath();
    for (let i = 0; i + CORRESPONDENCE_STRIDE <= rows.length; i += CORRESPONDENCE_STRIDE) {
      const at = (field: number): number => rows[i + field] ?? 0;
      const weight = at(CORRESPONDENCE.weight);
      if (weight < low || weight >= high) continue;
      line(context, camera, [at(CORRESPONDENCE.fromX), at(CORRESPONDENCE.fromY)], [at(CORRESPONDENCE.toX), at(CORRESPONDENCE.toY)]);
    }
    context.stroke();
  }
  context.globalAlpha = 1;
}

/** The search range at some of the points: circles of one standard deviation, or cells. */
export function drawWidths({ context, camera, colours }: Brush, points: Float64Array, pose: Pose, width: number, isCell: boolean): void {
  const every = Math.max(1, Math.ceil(points.length / 2 / MOST_WIDTHS));
  const size = width * camera.scale;
  context.strokeStyle = context.fillStyle = colours.width;
  context.lineWidth = 1;
  context.beginPath();
  const seen = new Set<string>();
  for (let i = 0; i + 1 < points.length; i += 2 * every) {
    const [x, y] = place(pose, points[i] ?? 0, points[i + 1] ?? 0);
    if (isCell) {
      const [column, row] = [Math.floor(x / width), Math.floor(y / width)];
      if (seen.has(`${column} ${row}`)) continue;
      seen.add(`${column} ${row}`);
      const [left, top] = camera.toScreen(column * width, (row + 1) * width);
      context.rect(left, top, size, size);
    } else {
      const [screenX, screenY] = camera.toScreen(x, y);
      context.moveTo(screenX + size, screenY);
      context.arc(screenX, screenY, size, 0, 2 * Math.PI);
    }
  }
  context.globalAlpha = 0.04;
  context.fill();
  context.globalAlpha = 0.32;
  context.stroke();
  context.globalAlpha = 1;
}

/** The unobservable direction, through the moving cloud's origin. */
export function drawDirection({ context, camera, colours }: Brush, pose: Pose, [dx, dy]: readonly [number, number]): void {
  const [x, y] = camera.toScreen(pose[0], pose[1]);
  const length = 0.32 * Math.min(camera.width, camera.height);
  const [ux, uy] = [dx, -dy];
  context.strokeStyle = context.fillStyle = colours.warn;
  context.lineWidth = 2.5;
  context.beginPath();
  context.moveTo(x - ux * length, y - uy * length);
  context.lineTo(x + ux * length, y + uy * length);
  for (const end of [-1, 1]) {
    const [tipX, tipY] = [x + end * ux * length, y + end * uy * length];
    for (const side of [-1, 1]) {
      context.moveTo(tipX, tipY);
      context.lineTo(tipX - end * 9 * ux + side * 6 * uy, tipY - end * 9 * uy - side * 6 * ux);
    }
  }
  context.stroke();
}

/** The 95 % ellipse of the position, enlarged so that it is visible. Returns the factor, 0 if it is
    not drawn. */
export function drawEllipse({ context, camera, colours }: Brush, { pose, cov }: Found): number {
  const [xx = NaN, xy = NaN, , , yy = NaN] = cov;
  const [half, mean] = [Math.hypot(0.5 * (xx - yy), xy), 0.5 * (xx + yy)];
  const chi = Math.sqrt(5.991);
  const [a, b] = [chi * Math.sqrt(mean + half), chi * Math.sqrt(Math.max(mean - half, 0))];
  if (!(a > 0) || a > 10) return 0;
  const zoom = zoomOf(a * camera.scale);
  const [x, y] = camera.toScreen(pose[0], pose[1]);
  context.strokeStyle = colours.ink;
  context.lineWidth = 1.6;
  context.beginPath();
  context.ellipse(x, y, zoom * a * camera.scale, Math.max(zoom * b * camera.scale, 1), -0.5 * Math.atan2(2 * xy, xx - yy), 0, 2 * Math.PI);
  context.stroke();
  return zoom;
}

/** The least of 1, 10, 20, 50, 100, ... that makes so many pixels visible. */
function zoomOf(pixels: number): number {
  for (const zoom of [1, 10, 20, 50, 100, 200, 500, 1000]) if (zoom * pixels >= 16) return zoom;
  return 2000;
}

/** The moving cloud's origin with its heading. */
export function drawOrigin({ context, camera }: Brush, [px, py, heading]: Pose, colour: string): void {
  const [x, y] = camera.toScreen(px, py);
  context.strokeStyle = colour;
  context.lineWidth = 2;
  context.beginPath();
  context.arc(x, y, 4, 0, 2 * Math.PI);
  context.moveTo(x, y);
  context.lineTo(x + 15 * Math.cos(heading), y - 15 * Math.sin(heading));
  context.stroke();
}

function line(context: CanvasRenderingContext2D, camera: Camera, from: readonly [number, number], to: readonly [number, number]): void {
  context.moveTo(...camera.toScreen(...from));
  context.lineTo(...camera.toScreen(...to));
}
