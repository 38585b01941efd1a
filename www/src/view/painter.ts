// What the layers draw with. There are three back ends: a canvas's 2D context, WebGL2, and the
// context that writes SVG. A layer does not know which one it has.
//
// | part | what | 2D and SVG | WebGL2 |
// |---|---|---|---|
// | `Pencil` | single shapes, and text, with the part of a 2D context that layers use | the context itself | `gl/pencil.ts` |
// | `Bulk` | thousands of things at once | `canvas_bulk.ts` | `gl/pencil.ts`, from buffers that stay on the graphics card |

import type { Pen } from "./layers/layer.js";
import type { Tiles } from "./tiles.js";

/** What builds a path. */
export type PathPencil = Pick<CanvasPath, "moveTo" | "lineTo" | "closePath" | "arc" | "ellipse" | "rect">;

type OfCanvas = Pick<CanvasRenderingContext2D,
  | "save" | "restore" | "transform" | "translate" | "rotate" | "resetTransform" | "getTransform" | "globalAlpha" | "fillStyle" | "strokeStyle"
  | "lineWidth" | "lineCap" | "lineJoin" | "miterLimit" | "setLineDash" | "font" | "textAlign" | "beginPath" | "fillRect" | "fillText" | "strokeText" | "measureText">;

/** The part of a 2D context that layers draw with. */
export interface Pencil extends OfCanvas, PathPencil {
  setTransform(a: number, b: number, c: number, d: number, e: number, f: number): void;
  roundRect(x: number, y: number, width: number, height: number, radius: number): void;
  fill(rule?: CanvasFillRule): void;
  stroke(): void;
}

/** The common style of many things. */
export interface Crowd {
  readonly colour: string;
  readonly alpha?: number;
}

/** A side in metres as whole device pixels; halves are rounded up in spite of earlier rounding
    errors. */
export function wholeSide(side: number, pixelsPerMetre: number): number {
  return Math.max(1, Math.floor(side * pixelsPerMetre + 0.5 + 1e-6));
}

/** Draws thousands of things. Arrays are read only once: to change one, pass a new array. */
export interface Bulk {
  /** Cells of a grid, in the frame of the map. */
  tiles(tiles: Tiles): void;
  /** Upright squares on the canvas, around x y, x y, … in a frame at pose `place` in the context's;
      `side` in metres. */
  squares(points: Float32Array, side: number, crowd: Crowd, place?: readonly [number, number, number]): void;
  /** Lines x1 y1 x2 y2, …; width and dashes in CSS pixels. */
  segments(ends: Float32Array, pen: Pen): void;
}
