// The occupancy grid: stretches its tiles over the canvas, and rules a grid of metres over them.

import type { Brush } from "./layer.js";

/** Tiles meet on whole device pixels, or seams would show. */
export function draw({ context, camera, tiles }: Pick<Brush, "context" | "camera" | "tiles">): void {
  const side = tiles.tileCells * tiles.resolution;
  const pixel = (x: number, y: number): [number, number] => {
    const [screenX, screenY] = camera.toScreen(x, y);
    return [Math.round(screenX * camera.ratio), Math.round(screenY * camera.ratio)];
  };
  const view = camera.visible;
  context.resetTransform();
  context.imageSmoothingEnabled = camera.scale * camera.ratio * tiles.resolution < 1;
  for (const tile of tiles.all()) {
    const [x, y] = [tile.col * side, tile.row * side];
    if (x > view.maxX || y > view.maxY || x + side < view.minX || y + side < view.minY) continue;
    const [left, top] = pixel(x, y + side);
    const [right, bottom] = pixel(x + side, y);
    context.drawImage(tile.canvas, left, top, right - left, bottom - top);
  }
}

/** Thin lines every `step` metres, chosen by `ruleStep`. */
export function drawRules({ context, camera, palette }: Brush): void {
  const step = ruleStep(camera.scale);
  const view = camera.visible;
  context.strokeStyle = palette.css.gridline;
  context.lineWidth = camera.px(1);
  for (const [every, alpha] of [[step, 0.5], [step * 5, 1]] as const) {
    context.globalAlpha = alpha;
    context.beginPath();
    for (let x = Math.ceil(view.minX / every) * every; x <= view.maxX; x += every) {
      context.moveTo(x, view.minY);
      context.lineTo(x, view.maxY);
    }
    for (let y = Math.ceil(view.minY / every) * every; y <= view.maxY; y += every) {
      context.moveTo(view.minX, y);
      context.lineTo(view.maxX, y);
    }
    context.stroke();
  }
}

/** A round number of metres that is at least 24 pixels wide. */
export function ruleStep(scale: number): number {
  for (const step of [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50]) if (step * scale >= 24) return step;
  return 100;
}
