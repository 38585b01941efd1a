// The map on three 2D canvases. A canvas that takes too long to be redrawn for each picture is
// moved with the view by the browser until it is redrawn.
//
// Without a graphics card browsers copy every 2D canvas for each picture of the page, whether it
// changed or not. The sheet that is rarely redrawn, and then as a whole, is therefore shown as a
// bitmap.

import { Camera, type Box } from "./camera.js";
import { CanvasBulk, type Context2D } from "./canvas_bulk.js";
import { type Draw, SHEETS, type SheetName, type Surface } from "./surface.js";

/** The sheet that is shown as a bitmap. */
const STILL: SheetName = "record";

interface Sheet {
  readonly canvas: HTMLCanvasElement;
  /** Shows the bitmaps of the sheet; null if its canvas is drawn on directly. */
  readonly shown: ImageBitmapRenderingContext | null;
  /** The view that it was last drawn for; null before that. */
  camera: Camera | null;
  moved: string;
}

export class CanvasSurface implements Surface {
  readonly kind = "canvas";
  readonly #sheets: Readonly<Record<SheetName, Sheet>>;

  constructor(canvasOf: (sheet: SheetName) => HTMLCanvasElement) {
    const sheetOf = (name: SheetName): Sheet => {
      const canvas = canvasOf(name);
      return { canvas, shown: name === STILL ? canvas.getContext("bitmaprenderer") : null, camera: null, moved: "" };
    };
    this.#sheets = Object.fromEntries(SHEETS.map((name) => [name, sheetOf(name)])) as unknown as Record<SheetName, Sheet>;
  }

  resize({ width, height, ratio }: Camera): void {
    for (const sheet of Object.values(this.#sheets)) {
      Object.assign(sheet.canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
      sheet.camera = null;
    }
  }

  record(name: SheetName, camera: Camera, within: Box | null, draw: Draw): void {
    const sheet = this.#sheets[name];
    const { canvas: { width, height }, shown } = sheet;
    if (shown) {
      const canvas = new OffscreenCanvas(width, height);
      const context = contextOf(canvas);
      draw(context, new CanvasBulk(context, camera));
      shown.transferFromImageBitmap(canvas.transferToImageBitmap());
    } else {
      const context = contextOf(sheet.canvas);
      context.save();
      if (within && Number.isFinite(within.minX)) clip(context, camera, within);
      context.resetTransform();
      context.clearRect(0, 0, width, height);
      draw(context, new CanvasBulk(context, camera));
      context.restore();
    }
    sheet.camera = Object.assign(sheet.camera ?? new Camera(), camera);
  }

  show(camera: Camera): void {
    for (const sheet of Object.values(this.#sheets)) {
      const moved = sheet.camera ? motion(sheet.camera, camera) : "";
      if (moved !== sheet.moved) sheet.canvas.style.setProperty("transform", moved);
      sheet.moved = moved;
    }
  }

  takeStale(): boolean {
    return false;
  }

  clear(): void {
    for (const sheet of Object.values(this.#sheets)) {
      sheet.canvas.width = sheet.canvas.height = 1;
      sheet.camera = null;
    }
  }

  copyTo(context: OffscreenCanvasRenderingContext2D): void {
    for (const name of SHEETS) context.drawImage(this.#sheets[name].canvas, 0, 0);
  }
}

/** The change of view as a CSS transform; empty if there is none. */
function motion(from: Camera, to: Camera): string {
  const at = (x: number, y: number): [number, number] => to.toScreen(...from.toMap(x, y));
  const [[x, y], [rightX, rightY], [downX, downY]] = [at(0, 0), at(1, 0), at(0, 1)];
  const matrix = [rightX - x, rightY - y, downX - x, downY - y, x, y];
  const isThere = [1, 0, 0, 1, 0, 0].every((value, i) => Math.abs(value - (matrix[i] ?? NaN)) < 1e-6);
  return isThere ? "" : `matrix(${matrix.map((value) => value.toFixed(9)).join()})`;
}

/** Clips to whole pixels, with a margin for smoothing. */
function clip(context: Context2D, camera: Camera, { minX, minY, maxX, maxY }: Box): void {
  const corners = [camera.toScreen(minX, maxY), camera.toScreen(maxX, maxY), camera.toScreen(minX, minY), camera.toScreen(maxX, minY)];
  const [xs, ys] = [corners.map(([x]) => x * camera.ratio), corners.map(([, y]) => y * camera.ratio)];
  const [left, top] = [Math.floor(Math.min(...xs)) - 2, Math.floor(Math.min(...ys)) - 2];
  context.resetTransform();
  context.beginPath();
  context.rect(left, top, Math.ceil(Math.max(...xs)) + 2 - left, Math.ceil(Math.max(...ys)) + 2 - top);
  context.clip();
}

function contextOf(canvas: HTMLCanvasElement | OffscreenCanvas): Context2D {
  const context = canvas.getContext("2d");
  if (!context) throw new Error("this browser gives no 2D canvas");
  return context;
}
