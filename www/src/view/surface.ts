// What the map is drawn on: three sheets, each drawn anew when it is due, and moved with the view
// until then. Canvases, or one WebGL2 canvas (`gl/surface.ts`).

import type { Box, Camera } from "./camera.js";
import type { Bulk, Pencil } from "./painter.js";

/** The lowest first: what changes with the map, what grows with a run, and what moves. */
export const SHEETS = ["ground", "record", "overlays"] as const;
export type SheetName = (typeof SHEETS)[number];

export type Draw = (context: Pencil, bulk: Bulk) => void;

export interface Surface {
  readonly kind: "canvas" | "webgl2";
  /** Takes the size of the view; all is to be drawn anew. */
  resize(camera: Camera): void;
  /** Draws a sheet anew, as far as possible only `within` a part of the map. */
  record(sheet: SheetName, camera: Camera, within: Box | null, draw: Draw): void;
  /** Puts all sheets where they belong in this view. */
  show(camera: Camera): void;
  /** Whether all has to be recorded again, since it was asked last. */
  takeStale(): boolean;
  /** Nothing is to be seen on it from here on. */
  clear(): void;
  /** Draws what is seen into a context of the same size. */
  copyTo(context: OffscreenCanvasRenderingContext2D, camera: Camera): void;
}
