// The true walls as a picture that is repainted only when it has to be: a town has 50 000 of them,
// and the view glides.
//
// 1. Few walls are drawn each time, crisp.
// 2. Many are painted once into a picture somewhat larger than the view, which is then only moved
//    and stretched.
// 3. It is repainted when the view leaves it, when it would be stretched by more than a quarter, or
//    when the view stands.

import type { Box } from "../camera.js";
import type { Brush } from "./layer.js";
import { drawWalls } from "./truth.js";

/** Walls that are drawn each time at most. */
const FEW = 3000;
/** What is painted beyond each side of the view, as a part of it. */
const SPARE = 0.25;
/** How much it may be stretched before it is repainted. */
const STRETCH = 1.25;

interface Painted {
  readonly canvas: OffscreenCanvas;
  readonly walls: Float32Array;
  readonly colour: string;
  readonly box: Box;
  readonly scale: number;
}

export class TruthPicture {
  #painted: Painted | null = null;
  #last = "";

  draw(brush: Brush): void {
    const { context, camera, palette, scene } = brush;
    if (scene.truth.length / 4 <= FEW) {
      this.#painted = null;
      drawWalls(context, scene.truth, scene.materials, camera.visible, camera.px(1), palette);
      return;
    }
    const view = [camera.x, camera.y, camera.scale, camera.width, camera.height].join();
    const stands = view === this.#last;
    this.#last = view;
    if (!this.#painted || !this.#fits(this.#painted, brush) || (stands && this.#painted.scale !== camera.scale)) this.#painted = paint(brush);
    const { canvas, box } = this.#painted;
    const [left, top] = camera.toScreen(box.minX, box.maxY);
    const [right, bottom] = camera.toScreen(box.maxX, box.minY);
    context.resetTransform();
    context.drawImage(canvas, left * camera.ratio, top * camera.ratio, (right - left) * camera.ratio, (bottom - top) * camera.ratio);
  }

  #fits(painted: Painted, { camera, palette, scene }: Brush): boolean {
    const view = camera.visible;
    const { box } = painted;
    const stretch = camera.scale / painted.scale;
    return painted.walls === scene.truth && painted.colour === palette.css.truth && stretch <= STRETCH && stretch >= 1 / STRETCH
      && view.minX >= box.minX && view.maxX <= box.maxX && view.minY >= box.minY && view.maxY <= box.maxY;
  }
}

function paint({ camera, palette, scene }: Brush): Painted {
  const view = camera.visible;
  const [spareX, spareY] = [SPARE * (view.maxX - view.minX), SPARE * (view.maxY - view.minY)];
  const box = { minX: view.minX - spareX, maxX: view.maxX + spareX, minY: view.minY - spareY, maxY: view.maxY + spareY };
  const k = camera.scale * camera.ratio;
  const canvas = new OffscreenCanvas(Math.max(1, Math.round(k * (box.maxX - box.minX))), Math.max(1, Math.round(k * (box.maxY - box.minY))));
  const context = canvas.getContext("2d");
  if (context) {
    context.setTransform(k, 0, 0, -k, -k * box.minX, k * box.maxY);
    drawWalls(context, scene.truth, scene.materials, box, camera.px(1), palette);
  }
  return { canvas, walls: scene.truth, colour: palette.css.truth, box, scale: camera.scale };
}
