// The occupancy grid, and the lines ruled over it every so many metres.

import type { Status } from "../../protocol/frame.js";
import type { Brush } from "./layer.js";

/** Opacity of the map while the robot's pose is in doubt. */
const IN_DOUBT = 0.35;

/** A robot that is lost, or mistakes one place for another, draws a map of a place where it is not:
    the map is drawn faintly until that is decided. */
export function draw({ context, bulk, tiles, scene: { status } }: Brush): void {
  context.globalAlpha = status && isInDoubt(status) ? IN_DOUBT : 1;
  bulk.tiles(tiles);
  context.globalAlpha = 1;
}

export function isInDoubt({ localisation, placed }: Pick<Status, "localisation" | "placed">): boolean {
  return localisation === "lost" || localisation === "ambiguous" || !placed;
}

/** How far lines are ruled beyond the view, as a part of it: the picture may move before it is
    redrawn. */
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
