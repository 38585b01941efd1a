// What every layer receives.

import type { ContestState, EditName, FenceZone, Rooms, Sighting, Tear } from "../../protocol/module.js";
import type { Compared } from "../../compared.js";
import type { FenceDraft, Place } from "../../fence.js";
import type { LoadedMap, Spot } from "../../store.js";
import { type Camera, clamp } from "../camera.js";
import type { Bulk, PathPencil, Pencil } from "../painter.js";
import type { Palette } from "../palette.js";
import type { Scene } from "../scene.js";
import type { Tiles } from "../tiles.js";
import type { Thing } from "../things.js";

/** The context draws in map metres, y up. */
export interface Brush {
  readonly context: Pencil;
  readonly bulk: Bulk;
  readonly camera: Camera;
  readonly palette: Palette;
  readonly scene: Scene;
  /** The grid, or the field of it that is shown. */
  readonly tiles: Tiles;
  /** Length of the trail when the record sheet was last drawn. */
  readonly recordedTrail: number;
  /** Seconds since the page opened, for animations; constant if reduced motion is requested. */
  readonly time: number;
  /** Whether the truth, and the robot's place by odometry alone, are shown. */
  readonly truth: boolean;
  readonly byWheels: boolean;
  /** Walls to be highlighted. */
  readonly spot: Spot;
  /** Planners side by side, while their tab is open. */
  readonly contest: { readonly found: ContestState | null; readonly start: readonly [number, number] | null; readonly goal: readonly [number, number] | null } | null;
  /** The edit in progress, and its two places; null if there is none. */
  readonly edit: { readonly kind: EditName; readonly draft: { readonly from: readonly [number, number]; readonly to: readonly [number, number] } | null } | null;
  /** Rooms and doors, and the number of the chosen one. */
  readonly rooms: { readonly found: Rooms; readonly numbers: readonly number[]; readonly chosen: number | null } | null;
  /** What other methods made of the same log. */
  readonly compared: readonly Compared[];
  /** The chosen thing, and its outline. */
  readonly thing: Thing | null;
  readonly outline: Outline;
  /** Submaps that are not drawn, and the one chosen in their list. */
  readonly hiddenSubmaps: ReadonlySet<number>;
  readonly chosenSubmap: number | null;
  /** Maps that were loaded. */
  readonly loadedMaps: readonly LoadedMap[];
  /** The walls of the bridge's own map, the place of its frame (null while unknown), its geofence,
      and the part of that being drawn. */
  readonly bridgeMap: { readonly place: Place | null; readonly walls: Float32Array; readonly zones: readonly FenceZone[]; readonly draft: FenceDraft | null };
  /** Where the map is torn or doubtful. */
  readonly tears: readonly Tear[];
  /** Lines of the last scan with what they were compared with; empty while the filter's tab is
      closed. */
  readonly sightings: readonly Sighting[];
}

/** Polylines of map points, m. */
export type Outline = readonly (readonly (readonly [number, number])[])[];

/** How a line is drawn: width and dashes in CSS pixels. */
export interface Pen {
  readonly colour: string;
  readonly width: number;
  readonly alpha?: number;
  readonly dash?: readonly number[];
}

/** Strokes the path made by `add`. */
export function stroke({ context, camera }: Brush, { colour, width, alpha = 1, dash = [] }: Pen, add: () => void): void {
  context.strokeStyle = colour;
  context.lineWidth = camera.px(width);
  context.globalAlpha = alpha;
  context.setLineDash(dash.map((length) => camera.px(length)));
  context.beginPath();
  add();
  context.stroke();
}

/** Fills a disc; its radius is in metres. */
export function disc({ context }: Brush, x: number, y: number, radius: number): void {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fill();
}

/** Writes upright beside a map point: `write` works in CSS pixels, relative to that point. */
export function label({ context, camera }: Brush, mapX: number, mapY: number, write: () => void): void {
  const [x, y] = camera.toScreen(mapX, mapY);
  context.save();
  context.setTransform(camera.ratio, 0, 0, camera.ratio, x * camera.ratio, y * camera.ratio);
  write();
  context.restore();
}

/** The row whose segment (x1 y1 x2 y2, starting at its `place`) is nearest to a map point, within
    `reach`, m: where it begins. */
export function nearestSegment(rows: Float32Array | Float64Array, stride: number, place: number, x: number, y: number, reach: number): number | null {
  let [nearest, found] = [reach, null as number | null];
  for (let i = 0; i + stride <= rows.length; i += stride) {
    const [x1 = NaN, y1 = NaN, x2 = NaN, y2 = NaN] = rows.subarray(i + place, i + place + 4);
    const [dx, dy] = [x2 - x1, y2 - y1];
    const along = clamp(((x - x1) * dx + (y - y1) * dy) / (dx * dx + dy * dy || 1), 0, 1);
    const distance = Math.hypot(x - x1 - along * dx, y - y1 - along * dy);
    if (distance < nearest) [nearest, found] = [distance, i];
  }
  return found;
}

/** Adds x1 y1 x2 y2 … as separate strokes to the path. */
export function addSegments(context: PathPencil, data: ArrayLike<number>): void {
  for (let i = 0; i + 3 < data.length; i += 4) {
    context.moveTo(data[i] ?? 0, data[i + 1] ?? 0);
    context.lineTo(data[i + 2] ?? 0, data[i + 3] ?? 0);
  }
}

/** Adds x y, x y, … as one stroke to the path. */
export function addPolyline(context: PathPencil, data: Float32Array): void {
  for (let i = 0; i + 1 < data.length; i += 2) {
    if (i === 0) context.moveTo(data[0] ?? 0, data[1] ?? 0);
    else context.lineTo(data[i] ?? 0, data[i + 1] ?? 0);
  }
}
