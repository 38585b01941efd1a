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

/** How far beyond a changed part smoothing changes pixels, CSS pixels. */
const SMOOTHED = 2;
/** And how far beyond it things may lie that cover such pixels. */
const REACH = 6;

interface Sheet {
  readonly canvas: HTMLCanvasElement;
  /** What its bitmaps are drawn on, and shown with; null if its canvas is drawn on directly. */
  readonly still: { readonly drawn: OffscreenCanvas; readonly shown: ImageBitmapRenderingContext } | null;
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
      const shown = name === STILL ? canvas.getContext("bitmaprenderer") : null;
      return { canvas, still: shown && { drawn: new OffscreenCanvas(1, 1), shown }, camera: null, moved: "" };
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
    const { canvas: { width, height }, still } = sheet;
    if (still) {
      const { drawn, shown } = still;
      if (drawn.width !== width || drawn.height !== height) Object.assign(drawn, { width, height });
      const context = contextOf(drawn);
      draw(context, new CanvasBulk(context, camera, camera.visible));
      shown.transferFromImageBitmap(drawn.transferToImageBitmap());
    } else {
      const context = contextOf(sheet.canvas);
      context.save();
      const part = within && Number.isFinite(within.minX) ? within : null;
      if (part) clip(context, camera, widened(part, camera.px(SMOOTHED)));
      context.resetTransform();
      context.clearRect(0, 0, width, height);
      draw(context, new CanvasBulk(context, camera, part ? widened(part, camera.px(REACH)) : camera.visible));
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

/** A box with a margin on each side, m. */
function widened({ minX, minY, maxX, maxY }: Box, margin: number): Box {
  return { minX: minX - margin, minY: minY - margin, maxX: maxX + margin, maxY: maxY + margin };
}

/** Clips to whole pixels. */
function clip(context: Context2D, camera: Camera, { minX, minY, maxX, maxY }: Box): void {
  const corners = [camera.toScreen(minX, maxY), camera.toScreen(maxX, maxY), camera.toScreen(minX, minY), camera.toScreen(maxX, minY)];
  const [xs, ys] = [corners.map(([x]) => x * camera.ratio), corners.map(([, y]) => y * camera.ratio)];
  const [left, top] = [Math.floor(Math.min(...xs)), Math.floor(Math.min(...ys))];
  context.resetTransform();
  context.beginPath();
  context.rect(left, top, Math.ceil(Math.max(...xs)) - left, Math.ceil(Math.max(...ys)) - top);
  context.clip();
}

function contextOf(canvas: HTMLCanvasElement | OffscreenCanvas): Context2D {
  const context = canvas.getContext("2d");
  if (!context) throw new Error("this browser gives no 2D canvas");
  return context;
}
