// The geofence in the bridge's map, and the part that is being drawn.

import type { FenceZone } from "../../protocol/module.js";
import { type Brush, disc, stroke } from "./layer.js";

type Corners = readonly (readonly [number, number])[];

/** Radius of a corner that is being drawn, CSS pixels. */
const CORNER = 4.5;

export function draw(brush: Brush): void {
  const { context, camera, palette: { css }, bridgeMap: { place, zones, draft } } = brush;
  if (!place) return;
  context.translate(place[0], place[1]);
  context.rotate(place[2]);
  for (const zone of draft?.zones ?? zones) area(brush, zone);
  if (!draft || draft.corners.length === 0) return;
  border(brush, draft.keepOut, () => polygon(brush, draft.corners, false));
  context.globalAlpha = 1;
  context.fillStyle = css.ink;
  for (const [x, y] of draft.corners) disc(brush, x, y, camera.px(CORNER));
}

function area(brush: Brush, { keepOut, corners }: FenceZone): void {
  const { context, palette: { css } } = brush;
  if (keepOut) {
    context.globalAlpha = 0.16;
    context.fillStyle = css.torn;
    context.beginPath();
    polygon(brush, corners, true);
    context.fill();
  }
  border(brush, keepOut, () => polygon(brush, corners, true));
}

/** Dashes distinguish the two kinds without colours. */
function border(brush: Brush, keepOut: boolean, add: () => void): void {
  const { css } = brush.palette;
  stroke(brush, { colour: css.free, width: 5, alpha: 0.8 }, add);
  stroke(brush, { colour: keepOut ? css.torn : css.ink, width: 2.2, dash: keepOut ? [3, 4] : [12, 5] }, add);
}

function polygon({ context }: Brush, corners: Corners, isClosed: boolean): void {
  corners.forEach(([x, y], i) => (i === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  if (isClosed) context.closePath();
}
