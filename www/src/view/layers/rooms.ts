// Rooms and corridors tinted and numbered, the doors between them with their widths, and the graph
// that connects them.

import type { Region, Rooms } from "../../protocol/module.js";
import type { PathPencil } from "../painter.js";
import type { PaletteName } from "../palette.js";
import { addPolyline, addSegments, type Brush, disc, label, stroke } from "./layer.js";

/** Tints of rooms, used in turn; a corridor is grey. */
const TINTS = ["contest5", "contest3", "contest0", "contest2", "contest1"] as const satisfies readonly PaletteName[];
const CORRIDOR = "contest4" satisfies PaletteName;
/** Pixels per metre from which on widths are written, and from which on the shorter numbers are. */
const WRITTEN_FROM = 22;
const NUMBERED_FROM = 8;

export function draw(brush: Brush): void {
  const { context, camera, palette, rooms } = brush;
  if (!rooms) return;
  const { found, numbers, chosen } = rooms;
  found.regions.forEach(({ kind, outlines }, region) => {
    const colour = palette.css[kind === "corridor" ? CORRIDOR : TINTS[((numbers[region] ?? 1) - 1) % TINTS.length] ?? CORRIDOR];
    context.fillStyle = colour;
    context.globalAlpha = region === chosen ? 0.5 : 0.24;
    // A context that writes a file cannot read a finished path.
    const canvas = context instanceof CanvasRenderingContext2D ? context : null;
    if (canvas) canvas.fill(pathOf(outlines), "evenodd");
    else {
      context.beginPath();
      trace(context, outlines);
      context.fill("evenodd");
    }
    if (region !== chosen) return;
    context.globalAlpha = 1;
    context.strokeStyle = palette.css.ink;
    context.lineWidth = camera.px(2);
    if (canvas) canvas.stroke(pathOf(outlines));
    else context.stroke();
  });
  drawGraph(brush, found);
  if (camera.scale >= WRITTEN_FROM) for (const { middle, width } of found.doors) write(brush, middle, `${Math.round(100 * width)} cm`, 500);
  if (camera.scale >= NUMBERED_FROM) found.regions.forEach(({ middle }, region) => write(brush, middle, String(numbers[region] ?? ""), 600));
}

function write(brush: Brush, [x, y]: readonly [number, number], text: string, weight: number): void {
  const { context, palette } = brush;
  label(brush, x, y, () => {
    context.font = `${weight} ${weight > 500 ? 13 : 11}px IBM Plex Mono, monospace`;
    context.lineWidth = 3;
    context.strokeStyle = palette.css.free;
    context.fillStyle = palette.css.ink;
    context.strokeText(text, 7, -6);
    context.fillText(text, 7, -6);
  });
}

function drawGraph(brush: Brush, { regions, doors }: Rooms): void {
  const { context, camera, palette } = brush;
  stroke(brush, { colour: palette.css.ink, width: 1.2, alpha: 0.6 }, () => {
    for (const { regions: ends, middle } of doors) {
      for (const end of ends) addSegments(context, [...(regions[end]?.middle ?? middle), ...middle]);
    }
  });
  context.globalAlpha = 1;
  context.fillStyle = palette.css.ink;
  for (const { middle: [x, y] } of regions) disc(brush, x, y, camera.px(4));
  for (const { posts, framed } of doors) {
    stroke(brush, { colour: palette.css.door, width: 3, dash: framed ? [] : [3, 3] }, () => addSegments(context, posts));
  }
  context.setLineDash([]);
}

/** Outlines are built once, because they are drawn in every frame. */
const paths = new WeakMap<Region["outlines"], Path2D>();

function pathOf(outlines: Region["outlines"]): Path2D {
  const path = paths.get(outlines) ?? new Path2D();
  if (paths.has(outlines)) return path;
  paths.set(outlines, path);
  trace(path, outlines);
  return path;
}

function trace(path: PathPencil, outlines: Region["outlines"]): void {
  for (const ring of outlines) {
    addPolyline(path, ring);
    path.closePath();
  }
}
