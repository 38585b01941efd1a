// The occupancy grid, and the metres that are ruled over it.

import type { Status } from "../../protocol/frame.js";
import type { Brush } from "./layer.js";

/** How much of the map is seen while nobody knows whether the robot is where it is drawn. */
const IN_DOUBT = 0.35;

/** A map that a robot draws which is lost, or takes one place for another, is one of a place where
    it is not: it is drawn faintly until that is decided. */
export function draw({ context, bulk, tiles, scene: { status } }: Brush): void {
  context.globalAlpha = status && isInDoubt(status) ? IN_DOUBT : 1;
  bulk.tiles(tiles);
  context.globalAlpha = 1;
}

export function isInDoubt({ localisation, placed }: Pick<Status, "localisation" | "placed">): boolean {
  return localisation === "lost" || localisation === "ambiguous" || !placed;
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
