// What every layer is given.

import type { Sighting } from "../../inspect.js";
import type { ContestState, Rooms } from "../../protocol/module.js";
import type { Spot } from "../../store.js";
import type { Camera } from "../camera.js";
import type { Palette } from "../palette.js";
import type { Scene } from "../scene.js";
import type { Tiles } from "../tiles.js";

/** The context draws in map metres, y up. */
export interface Brush {
  readonly context: CanvasRenderingContext2D;
  readonly camera: Camera;
  readonly palette: Palette;
  readonly scene: Scene;
  /** What the grid shows. */
  readonly tiles: Tiles;
  /** Seconds since the page opened, for what breathes; stands still where reduced motion is asked
      for. */
  readonly time: number;
  /** Walls that light up. */
  readonly spot: Spot;
  /** Planners side by side, while their tab is open. */
  readonly contest: { readonly found: ContestState | null; readonly start: readonly [number, number] | null; readonly goal: readonly [number, number] | null } | null;
  /** Rooms and doors, and the number of the chosen one. */
  readonly rooms: { readonly found: Rooms; readonly numbers: readonly number[]; readonly chosen: number | null } | null;
  /** Lines of the last scan with what they were compared with; empty while the filter's tab is
      closed. */
  readonly sightings: readonly Sighting[];
}

/** Adds x1 y1 x2 y2 … as separate strokes to the path. */
export function addSegments(context: CanvasRenderingContext2D, data: Float32Array): void {
  for (let i = 0; i + 3 < data.length; i += 4) {
    context.moveTo(data[i] ?? 0, data[i + 1] ?? 0);
    context.lineTo(data[i + 2] ?? 0, data[i + 3] ?? 0);
  }
}

/** Adds x y, x y, … as one stroke to the path. */
export function addPolyline(context: CanvasRenderingContext2D, data: Float32Array): void {
  for (let i = 0; i + 1 < data.length; i += 2) {
    if (i === 0) context.moveTo(data[0] ?? 0, data[1] ?? 0);
    else context.lineTo(data[i] ?? 0, data[i + 1] ?? 0);
  }
}
