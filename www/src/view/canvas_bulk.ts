// Draws thousands of things with a 2D context, of a canvas or of a drawing.

import { type Box, type Camera, isOutside } from "./camera.js";
import type { Pen } from "./layers/layer.js";
import { type Bulk, type Crowd, wholeSide } from "./painter.js";
import { rgb } from "./palette.js";
import type { Tiles } from "./tiles.js";

/** Up to this many squares are drawn as a path, and up to this many lines are stroked each time,
    crisply. With more, a path would take a hundred milliseconds. */
const MOST_IN_PATH = 3000;
/** Squares of this side, device pixels, are written without an inner loop: 2.5 px if a CSS pixel is
    a device pixel. */
const USUAL_SIDE = 3;
/** How far lines are painted beyond each side of the view, as a part of it. */
const SPARE = 0.25;
/** How far an image of lines may be stretched before it is painted again. */
const STRETCH = 1.25;
/** A view turned by less than this counts as upright, rad. */
const LEAST_TURN = 1e-6;

/** The context of a visible or an off-screen canvas. */
export type Context2D = CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D;

export class CanvasBulk implements Bulk {
  /** `part`: where something has to be drawn. What lies outside is left out, because to clip it
      takes the browser as long as to draw it. */
  constructor(readonly context: Context2D, readonly camera: Camera, readonly part: Box) {}

  tiles(tiles: Tiles): void {
    drawTiles(this.context, this.camera, tiles, this.part);
  }

  squares(points: Float32Array, side: number, { colour, alpha = 1 }: Crowd, [x, y, heading]: readonly [number, number, number] = [0, 0, 0]): void {
    const { context, camera } = this;
    const { a, b, c, d, e, f } = context.getTransform();
    const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
    const pixels = wholeSide(side, Math.hypot(a, b));
    // Maps a point to the upper left corner of its square, in device pixels.
    const place: Place = {
      a: a * cos + c * sin, b: b * cos + d * sin, c: c * cos - a * sin, d: d * cos - b * sin,
      e: a * x + c * y + e - pixels / 2, f: b * x + d * y + f - pixels / 2,
    };
    context.save();
    context.resetTransform();
    context.globalAlpha = alpha;
    (points.length / 2 > MOST_IN_PATH ? setPixels : fillPath)(context, sizeOf(camera), points, place, pixels, colour);
    context.restore();
  }

  segments(ends: Float32Array, pen: Pen): void {
    const { context, camera, part } = this;
    if (ends.length / 4 > MOST_IN_PATH) return this.#picture(ends, pen);
    context.save();
    strokeWithin(context, ends, part, pen, camera.px(1));
    context.restore();
  }

  /** Paints many lines once, into an image somewhat larger than the view, which is then only moved
      and stretched. It is painted again when the view leaves it, or comes to rest. */
  #picture(ends: Float32Array, pen: Pen): void {
    const { context, camera } = this;
    const view = [camera.x, camera.y, camera.scale, camera.angle, camera.width, camera.height].join();
    const last = pictures.get(ends);
    const stands = last?.view === view;
    const fits = last !== undefined && last.colour === pen.colour && holds(last, camera) && !(stands && last.scale !== camera.scale);
    const picture = fits ? last : { ...pictureOf(ends, pen, camera), view };
    picture.view = view;
    pictures.set(ends, picture);
    const { canvas, box } = picture;
    context.save();
    context.transform(1, 0, 0, -1, 0, 0);
    context.drawImage(canvas, box.minX, -box.maxY, box.maxX - box.minX, box.maxY - box.minY);
    context.restore();
  }
}

/** Size in device pixels. */
function sizeOf({ width, height, ratio }: Camera): { width: number; height: number } {
  return { width: Math.round(width * ratio), height: Math.round(height * ratio) };
}

/** Stretches the tiles of a grid over the canvas. Unless the view is turned, they meet on whole
    device pixels; otherwise seams would show. */
export function drawTiles(context: Context2D, camera: Camera, tiles: Tiles, part: Box): void {
  const side = tiles.tileCells * tiles.resolution;
  const isTurned = Math.abs(camera.angle) > LEAST_TURN;
  context.save();
  context.imageSmoothingEnabled = camera.scale * camera.ratio * tiles.resolution < 1;
  if (!isTurned) context.resetTransform();
  else context.transform(1, 0, 0, -1, 0, 0);
  // Turned tiles overlap a little.
  const lap = isTurned ? camera.px(0.5) : 0;
  const pixel = (x: number, y: number): [number, number] => {
    const [screenX, screenY] = camera.toScreen(x, y);
    return [Math.round(screenX * camera.ratio), Math.round(screenY * camera.ratio)];
  };
  for (const tile of tiles.all()) {
    const [x, y] = [tile.col * side, tile.row * side];
    if (isOutside(part, x, y, x + side, y + side)) continue;
    const canvas = tiles.canvasOf(tile);
    if (isTurned) {
      context.drawImage(canvas, x, -y - side, side + lap, side + lap);
      continue;
    }
    const [left, top] = pixel(x, y + side);
    const [right, bottom] = pixel(x + side, y);
    context.drawImage(canvas, left, top, right - left, bottom - top);
  }
  context.restore();
}

/** The transform of a canvas: x' = ax + cy + e, y' = bx + dy + f. */
interface Place { readonly a: number; readonly b: number; readonly c: number; readonly d: number; readonly e: number; readonly f: number }
interface Size { readonly width: number; readonly height: number }

// Squares are upright and of whole pixels: turned, thousands of them take four times as long.

function fillPath(context: Context2D, { width, height }: Size, points: Float32Array, { a, b, c, d, e, f }: Place, side: number, colour: string): void {
  context.fillStyle = colour;
  context.beginPath();
  for (let i = 0; i + 1 < points.length; i += 2) {
    const [x, y] = [points[i] ?? NaN, points[i + 1] ?? NaN];
    const [left, top] = [a * x + c * y + e, b * x + d * y + f];
    if (left > -side && top > -side && left < width && top < height) context.rect(Math.round(left), Math.round(top), side, side);
  }
  context.fill();
}

let sheet: { readonly image: ImageData; readonly pixels: Uint32Array; readonly canvas: OffscreenCanvas } | null = null;

/** Writes squares one by one into an image as large as the canvas; only the part that contains them
    is used. */
function setPixels(context: Context2D, size: Size, points: Float32Array, place: Place, side: number, colour: string): void {
  const { left: leftmost, top: topmost, right, bottom } = within(size, extentOf(points), place, side);
  // Points without a finite position leave no box either.
  if (!(leftmost < right && topmost < bottom)) return;
  const { width, height } = size;
  if (sheet?.image.width !== width || sheet.image.height !== height) {
    const image = new ImageData(width, height);
    sheet = { image, pixels: new Uint32Array(image.data.buffer), canvas: new OffscreenCanvas(width, height) };
  }
  const { image, pixels, canvas } = sheet;
  const { a, b, c, d, e, f } = place;
  const [red, green, blue] = rgb(colour);
  const opaque = ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
  pixels.fill(0, topmost * width, bottom * width);
  for (let i = 0; i + 1 < points.length; i += 2) {
    const x = points[i] ?? NaN;
    const y = points[i + 1] ?? NaN;
    const left = a * x + c * y + e;
    const top = b * x + d * y + f;
    if (!(left > -side && top > -side && left < width && top < height)) continue;
    const column = Math.floor(left + 0.5);
    const row = Math.floor(top + 0.5);
    if (side === USUAL_SIDE && column >= 0 && row >= 0 && column + side <= width && row + side <= height) {
      let at = row * width + column;
      for (let rest = side; rest > 0; rest -= 1, at += width) pixels[at] = pixels[at + 1] = pixels[at + 2] = opaque;
      continue;
    }
    const from = Math.max(column, 0);
    const to = Math.min(column + side, width);
    const end = Math.min(row + side, height) * width;
    for (let start = Math.max(row, 0) * width; start < end; start += width) {
      for (let at = start + from; at < start + to; at += 1) pixels[at] = opaque;
    }
  }
  const part = [leftmost, topmost, right - leftmost, bottom - topmost] as const;
  canvas.getContext("2d")?.putImageData(image, 0, 0, ...part);
  context.drawImage(canvas, ...part, ...part);
}

/** The whole pixels of the canvas that can be covered by squares within a box. */
function within({ width, height }: Size, { minX, minY, maxX, maxY }: Box, { a, b, c, d, e, f }: Place, side: number): { left: number; top: number; right: number; bottom: number } {
  const corners = [[minX, minY], [minX, maxY], [maxX, minY], [maxX, maxY]] as const;
  const [lefts, tops] = [corners.map(([x, y]) => a * x + c * y + e), corners.map(([x, y]) => b * x + d * y + f)];
  return {
    left: Math.max(Math.floor(Math.min(...lefts)), 0), top: Math.max(Math.floor(Math.min(...tops)), 0),
    right: Math.min(Math.ceil(Math.max(...lefts)) + side, width), bottom: Math.min(Math.ceil(Math.max(...tops)) + side, height),
  };
}

/** The boxes around arrays of points, which may be empty; arrays do not change. */
const extents = new WeakMap<Float32Array, Box>();

function extentOf(points: Float32Array): Box {
  const known = extents.get(points);
  if (known) return known;
  let [minX, minY, maxX, maxY] = [Infinity, Infinity, -Infinity, -Infinity];
  for (let i = 0; i + 1 < points.length; i += 2) {
    const x = points[i] ?? NaN;
    const y = points[i + 1] ?? NaN;
    if (x < minX) minX = x;
    if (x > maxX) maxX = x;
    if (y < minY) minY = y;
    if (y > maxY) maxY = y;
  }
  const extent = { minX, minY, maxX, maxY };
  extents.set(points, extent);
  return extent;
}

interface Picture {
  readonly canvas: OffscreenCanvas;
  readonly colour: string;
  readonly box: Box;
  readonly scale: number;
  /** The view in which it was last drawn. */
  view: string;
}

const pictures = new WeakMap<Float32Array, Picture>();

function holds({ box, scale }: Picture, camera: Camera): boolean {
  const [view, stretch] = [camera.visible, camera.scale / scale];
  return stretch <= STRETCH && stretch >= 1 / STRETCH && view.minX >= box.minX && view.maxX <= box.maxX && view.minY >= box.minY && view.maxY <= box.maxY;
}

function pictureOf(ends: Float32Array, pen: Pen, camera: Camera): Omit<Picture, "view"> {
  const view = camera.visible;
  const [spareX, spareY] = [SPARE * (view.maxX - view.minX), SPARE * (view.maxY - view.minY)];
  const box = { minX: view.minX - spareX, maxX: view.maxX + spareX, minY: view.minY - spareY, maxY: view.maxY + spareY };
  const k = camera.scale * camera.ratio;
  const canvas = new OffscreenCanvas(Math.max(1, Math.round(k * (box.maxX - box.minX))), Math.max(1, Math.round(k * (box.maxY - box.minY))));
  const context = canvas.getContext("2d");
  if (context) {
    context.setTransform(k, 0, 0, -k, -k * box.minX, k * box.maxY);
    strokeWithin(context, ends, box, pen, camera.px(1));
  }
  return { canvas, colour: pen.colour, box, scale: camera.scale };
}

/** Strokes the lines that may cross `box`; `pixel` is the size of a CSS pixel, m. */
function strokeWithin(context: Context2D, ends: Float32Array, box: Box, { colour, width, alpha = 1, dash = [] }: Pen, pixel: number): void {
  context.strokeStyle = colour;
  context.globalAlpha = alpha;
  context.lineWidth = pixel * width;
  context.setLineDash(dash.map((length) => pixel * length));
  context.beginPath();
  for (let i = 0; i + 3 < ends.length; i += 4) {
    const [x1 = 0, y1 = 0, x2 = 0, y2 = 0] = [ends[i], ends[i + 1], ends[i + 2], ends[i + 3]];
    if (isOutside(box, x1, y1, x2, y2)) continue;
    context.moveTo(x1, y1);
    context.lineTo(x2, y2);
  }
  context.stroke();
}
