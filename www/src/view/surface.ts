// What the map is drawn on: three sheets, each redrawn when it is due, and moved with the view
// until then. Either canvases, or one WebGL2 canvas (`gl/surface.ts`).

import type { Box, Camera } from "./camera.js";
import type { Bulk, Pencil } from "./painter.js";

/** From the bottom: what changes with the map, what grows with a run, and what moves. */
export const SHEETS = ["ground", "record", "overlays"] as const;
export type SheetName = (typeof SHEETS)[number];

export type Draw = (context: Pencil, bulk: Bulk) => void;

export interface Surface {
  readonly kind: "canvas" | "webgl2";
  /** Adopts the size of the view; everything has to be redrawn. */
  resize(camera: Camera): void;
  /** Redraws a sheet, if possible only `within` a part of the map. */
  record(sheet: SheetName, camera: Camera, within: Box | null, draw: Draw): void;
  /** Moves all sheets to their places in this view. */
  show(camera: Camera): void;
  /** Whether everything has to be recorded again, since the last call. */
  takeStale(): boolean;
  /** Shows nothing from here on. */
  clear(): void;
  /** Draws the visible picture into a context of the same size. */
  copyTo(context: OffscreenCanvasRenderingContext2D, camera: Camera): void;
}
