// What the layers draw with. There are two back ends and a file: a canvas's 2D context, WebGL2, and
// the context that writes SVG. A layer does not know which one it has.
//
// | part | what | 2D and SVG | WebGL2 |
// |---|---|---|---|
// | `Pencil` | shapes one by one, and text, with what layers use of a 2D context | the context itself | `gl/pencil.ts` |
// | `Bulk` | what there are thousands of, at once | `canvas_bulk.ts` | `gl/pencil.ts`, from buffers that stay with the graphics card |

import type { Pen } from "./layers/layer.js";
import type { Tiles } from "./tiles.js";

/** What a path is made with. */
export type PathPencil = Pick<CanvasPath, "moveTo" | "lineTo" | "closePath" | "arc" | "ellipse" | "rect">;

type OfCanvas = Pick<CanvasRenderingContext2D,
  | "save" | "restore" | "transform" | "translate" | "rotate" | "resetTransform" | "getTransform" | "globalAlpha" | "fillStyle" | "strokeStyle"
  | "lineWidth" | "lineCap" | "lineJoin" | "miterLimit" | "setLineDash" | "font" | "textAlign" | "beginPath" | "fillRect" | "fillText" | "strokeText" | "measureText">;

/** Of a 2D context what layers draw with. */
export interface Pencil extends OfCanvas, PathPencil {
  setTransform(a: number, b: number, c: number, d: number, e: number, f: number): void;
  roundRect(x: number, y: number, width: number, height: number, radius: number): void;
  fill(rule?: CanvasFillRule): void;
  stroke(): void;
}

/** What many things have in common. */
export interface Crowd {
  readonly colour: string;
  readonly alpha?: number;
}

/** Device pixels of a side that is so long in metres; a half is a whole one, whatever was rounded
    before. */
export function wholeSide(side: number, pixelsPerMetre: number): number {
  return Math.max(1, Math.floor(side * pixelsPerMetre + 0.5 + 1e-6));
}

/** What there are thousands of. Arrays are read once and never again: whoever changes one hands
    over another. */
export interface Bulk {
  /** Cells of a grid, in the frame of the map. */
  tiles(tiles: Tiles): void;
  /** Squares that stand upright on the canvas, around x y, x y, … of a frame that lies at `place`
      in the context's; `side` in metres. */
  squares(points: Float32Array, side: number, crowd: Crowd, place?: readonly [number, number, number]): void;
  /** Lines x1 y1 x2 y2, …; width and dashes in CSS pixels. */
  segments(ends: Float32Array, pen: Pen): void;
}
