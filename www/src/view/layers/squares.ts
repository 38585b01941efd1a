// Many points as small squares. A few thousand are one path; of more, a path would cost a hundred
// milliseconds, so they are set pixel by pixel in a picture as large as the canvas.

import { rgb } from "../palette.js";
import type { Brush } from "./layer.js";

/** So many squares are drawn as a path. */
const MOST_IN_PATH = 3000;

let picture: { readonly image: ImageData; readonly pixels: Uint32Array; readonly canvas: OffscreenCanvas } | null = null;

/** Squares with sides of `size`, m, around x y, x y, …, as far as they are in sight. */
export function drawSquares(brush: Brush, points: Float32Array, colour: string, size: number): void {
  const { context, camera: { visible: { minX, minY, maxX, maxY } } } = brush;
  const isSeen = (x: number, y: number): boolean => x >= minX - size && x <= maxX + size && y >= minY - size && y <= maxY + size;
  let count = 0;
  for (let i = 0; i + 1 < points.length; i += 2) if (isSeen(points[i] ?? NaN, points[i + 1] ?? NaN)) count += 1;
  if (count > MOST_IN_PATH) return setPixels(brush, points, colour, size);
  context.fillStyle = colour;
  context.beginPath();
  for (let i = 0; i + 1 < points.length; i += 2) {
    const [x, y] = [points[i] ?? NaN, points[i + 1] ?? NaN];
    if (isSeen(x, y)) context.rect(x - size / 2, y - size / 2, size, size);
  }
  context.fill();
}

function setPixels({ context, camera }: Brush, points: Float32Array, colour: string, size: number): void {
  const { ratio } = camera;
  const [width, height] = [Math.round(camera.width * ratio), Math.round(camera.height * ratio)];
  if (picture?.image.width !== width || picture.image.height !== height) {
    const image = new ImageData(width, height);
    picture = { image, pixels: new Uint32Array(image.data.buffer), canvas: new OffscreenCanvas(width, height) };
  }
  const { image, pixels, canvas } = picture;
  const [red, green, blue] = rgb(colour);
  const opaque = ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
  const side = Math.max(1, Math.round(size * camera.scale * ratio));
  const scale = camera.scale * ratio;
  const [originX, originY] = camera.toScreen(0, 0).map((at) => at * ratio - side / 2) as [number, number];
  pixels.fill(0);
  for (let i = 0; i + 1 < points.length; i += 2) {
    const left = Math.round(originX + (points[i] ?? NaN) * scale);
    const top = Math.round(originY - (points[i + 1] ?? NaN) * scale);
    if (left >= width || top >= height || left + side <= 0 || top + side <= 0) continue;
    const [from, to] = [Math.max(left, 0), Math.min(left + side, width)];
    for (let row = Math.max(top, 0); row < Math.min(top + side, height); row += 1) {
      for (let at = row * width + from; at < row * width + to; at += 1) pixels[at] = opaque;
    }
  }
  canvas.getContext("2d")?.putImageData(image, 0, 0);
  context.save();
  context.resetTransform();
  context.drawImage(canvas, 0, 0);
  context.restore();
}
