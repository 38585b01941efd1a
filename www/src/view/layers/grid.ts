// The occupancy grid, and the metres that are ruled over it.

import type { Brush } from "./layer.js";

export function draw({ bulk, tiles }: Brush): void {
  bulk.tiles(tiles);
}

/** How far beside the view is ruled, too, as a part of it: what is seen may move before it is drawn
    anew. */
const RULED_BESIDE = 0.15;

/** Thin lines every `step` metres, chosen by `ruleStep`. */
export function drawRules({ context, camera, palette }: Brush): void {
  const step = ruleStep(camera.scale);
  const { minX, minY, maxX, maxY } = camera.visible;
  const beside = RULED_BESIDE * Math.max(maxX - minX, maxY - minY);
  const view = { minX: minX - beside, minY: minY - beside, maxX: maxX + beside, maxY: maxY + beside };
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
