// The map of the fleet: grid, and robots by shape and colour with their names.

import { type Box, type Camera, union } from "../view/camera.js";
import type { Palette } from "../view/palette.js";
import type { State } from "./model.js";

/** A robot's map, as the bridge sends it, in runs: each is four times its length, plus 0 for
    unknown, 1 for free, 2 for occupied. */
export interface MapBody {
  readonly revision: number;
  readonly cell: number;
  readonly corner: readonly [number, number];
  readonly width: number;
  readonly height: number;
  readonly runs: readonly number[];
}

export interface Grid { readonly image: ImageBitmap; readonly box: Box }

export interface Drawn {
  readonly name: string;
  readonly pose: readonly [number, number, number];
  readonly state: State;
  readonly chosen: boolean;
}

/** Radius of a robot's symbol, CSS pixels, so that it is visible at any zoom ... */
export const SIGN = 9;
/** ... but on a small map, where robots stand close together, it shrinks to SIGN_METRES, m, and not
    below this, CSS pixels. */
const LEAST_SIGN = 5;
const SIGN_METRES = 1.2;
/** Names are written where there is room for them, and at most this many, to keep a frame short. */
const MOST_NAMES = 60;
/** Height of a name, CSS pixels. */
const NAME = 15;
const MOST_CELLS = 64_000_000;

/** Null for a map without cells. */
export async function gridOf(map: MapBody, palette: Palette): Promise<Grid | null> {
  const { width, height, cell, corner: [x, y] } = map;
  if (!(width > 0 && height > 0 && width * height <= MOST_CELLS)) return null;
  const tones = [[0, 0, 0, 0], [...palette.tones.free, 255], [...palette.tones.occupied, 255]];
  const pixels = new ImageData(width, height);
  let at = 0;
  for (const run of map.runs) {
    const tone = tones[run & 3];
    for (const end = Math.min(at + Math.floor(run / 4), width * height); at < end; at += 1) {
      // The lowest row comes first in the map, and last in an image.
      if (tone) pixels.data.set(tone, 4 * ((height - 1 - Math.floor(at / width)) * width + (at % width)));
    }
  }
  return { image: await createImageBitmap(pixels), box: { minX: x, minY: y, maxX: x + width * cell, maxY: y + height * cell } };
}

/** The bounding box of grid and robots. */
export function boxOf(grid: Grid | null, robots: readonly Drawn[]): Box | null {
  return robots.reduce<Box | null>((box, { pose: [x, y] }) => union(box, { minX: x - 1, minY: y - 1, maxX: x + 1, maxY: y + 1 }), grid?.box ?? null);
}

export function colours(palette: Palette, style: CSSStyleDeclaration): Record<State, string> {
  const own = (name: string): string => style.getPropertyValue(name).trim();
  const [danger, warn] = [own("--danger"), own("--warn")];
  return { emergency: danger, away: own("--muted"), silent: warn, alert: warn, lost: warn, driving: palette.css.robot, standing: own("--good") };
}

export function draw(context: CanvasRenderingContext2D, camera: Camera, grid: Grid | null, robots: readonly Drawn[], palette: Palette, tone: Record<State, string>): void {
  context.setTransform(camera.ratio, 0, 0, camera.ratio, 0, 0);
  context.fillStyle = palette.css.unknown;
  context.fillRect(0, 0, camera.width, camera.height);
  if (grid) {
    const [left, top] = camera.toScreen(grid.box.minX, grid.box.maxY);
    const [right, bottom] = camera.toScreen(grid.box.maxX, grid.box.minY);
    context.imageSmoothingEnabled = false;
    context.drawImage(grid.image, left, top, right - left, bottom - top);
  }
  const sign = Math.min(SIGN, Math.max(LEAST_SIGN, SIGN_METRES * camera.scale));
  context.font = "500 12px sans-serif";
  context.textBaseline = "middle";
  for (const robot of robots) {
    const [x, y] = camera.toScreen(robot.pose[0], robot.pose[1]);
    context.save();
    context.translate(x, y);
    context.save();
    context.rotate(-robot.pose[2]);
    context.beginPath();
    for (const [right, down] of outline(robot.state)) context.lineTo(sign * right, sign * down);
    context.closePath();
    context.fillStyle = tone[robot.state];
    context.strokeStyle = palette.css.ink;
    context.lineWidth = 1.5;
    if (robot.state === "away") context.stroke();
    else {
      context.fill();
      context.stroke();
    }
    // The direction in which it looks.
    context.beginPath();
    context.moveTo(sign, 0);
    context.lineTo(1.8 * sign, 0);
    context.lineWidth = 2.5;
    context.stroke();
    context.restore();
    if (robot.chosen) {
      context.beginPath();
      context.arc(0, 0, 2.1 * sign, 0, 2 * Math.PI);
      context.lineWidth = 3;
      context.strokeStyle = palette.css.ink;
      context.stroke();
    }
    context.restore();
  }
  write(context, camera, robots, sign, palette);
}

/** Names beside their robots, without overlap: the chosen robot's name first. */
function write(context: CanvasRenderingContext2D, camera: Camera, robots: readonly Drawn[], sign: number, palette: Palette): void {
  context.lineWidth = 3;
  context.strokeStyle = palette.css.free;
  context.fillStyle = palette.css.ink;
  const taken: Box[] = [];
  for (const robot of [...robots.filter(({ chosen }) => chosen), ...robots.filter(({ chosen }) => !chosen)]) {
    if (taken.length >= MOST_NAMES) break;
    const [x, y] = camera.toScreen(robot.pose[0], robot.pose[1]);
    if (x < 0 || y < 0 || x > camera.width || y > camera.height) continue;
    const { width } = context.measureText(robot.name);
    const off = 1.6 * sign;
    const places = [[off, -off], [off, off], [-off - width, -off], [-off - width, off]] as const;
    const boxes = places.map(([right, down]): Box => ({ minX: x + right, maxX: x + right + width, minY: y + down - NAME / 2, maxY: y + down + NAME / 2 }));
    const box = boxes.find((box) => !taken.some((other) => overlap(box, other))) ?? (robot.chosen ? boxes[0] : undefined);
    if (!box) continue;
    taken.push(box);
    context.strokeText(robot.name, box.minX, (box.minY + box.maxY) / 2);
    context.fillText(robot.name, box.minX, (box.minY + box.maxY) / 2);
  }
}

function overlap(a: Box, b: Box): boolean {
  return a.minX < b.maxX && b.minX < a.maxX && a.minY < b.maxY && b.minY < a.maxY;
}

/** Corners of each state's shape, and the direction of the first, rad: not everyone can tell
    colours apart. */
const CORNERS: Readonly<Record<State, readonly [number, number]>> = {
  emergency: [8, Math.PI / 8], away: [4, Math.PI / 4], silent: [4, Math.PI / 4], alert: [4, 0], lost: [5, 0], driving: [3, 0], standing: [32, 0],
};

/** The shape in a circle of radius 1. */
export function outline(state: State): [number, number][] {
  const [count, first] = CORNERS[state];
  return Array.from({ length: count }, (_, n) => first + (2 * Math.PI * n) / count).map((angle) => [Math.cos(angle), Math.sin(angle)]);
}
