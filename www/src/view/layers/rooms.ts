// Rooms and corridors tinted and numbered, the doors between them with their widths, and the graph
// that joins them.

import { DOORWAY, DOORWAY_STRIDE, REGION, REGION_STRIDE, type Rooms } from "../../protocol/module.js";
import type { PaletteName } from "../palette.js";
import type { Brush } from "./layer.js";

/** Rooms take turns; a corridor is grey. */
const TINTS = ["contest5", "contest3", "contest0", "contest2", "contest1"] as const satisfies readonly PaletteName[];
const CORRIDOR = "contest4" satisfies PaletteName;
/** Pixels for a metre from which on widths are written, and from which on numbers, which are
    short. */
const WRITTEN_FROM = 22;
const NUMBERED_FROM = 8;

export function draw(brush: Brush): void {
  const { context, camera, palette, rooms } = brush;
  if (!rooms) return;
  const { found, numbers, chosen } = rooms;
  pathsOf(found).forEach((path, region) => {
    const isCorridor = found.regions[region * REGION_STRIDE + REGION.kind] === 1;
    const colour = palette.css[isCorridor ? CORRIDOR : TINTS[((numbers[region] ?? 1) - 1) % TINTS.length] ?? CORRIDOR];
    context.fillStyle = colour;
    context.globalAlpha = region === chosen ? 0.5 : 0.24;
    context.fill(path, "evenodd");
    if (region !== chosen) return;
    context.globalAlpha = 1;
    context.strokeStyle = palette.css.ink;
    context.lineWidth = camera.px(2);
    context.stroke(path);
  });
  context.globalAlpha = 1;
  drawGraph(brush, found);
  const { regions, doors } = found;
  for (let i = 0; camera.scale >= WRITTEN_FROM && i + DOORWAY_STRIDE <= doors.length; i += DOORWAY_STRIDE) {
    write(brush, doors[i + DOORWAY.x], doors[i + DOORWAY.y], `${Math.round(100 * (doors[i + DOORWAY.width] ?? NaN))} cm`, 500);
  }
  for (let i = 0; camera.scale >= NUMBERED_FROM && i + REGION_STRIDE <= regions.length; i += REGION_STRIDE) {
    write(brush, regions[i + REGION.x], regions[i + REGION.y], String(numbers[i / REGION_STRIDE] ?? ""), 600);
  }
}

/** Text stands upright beside its place: it is written in pixels, not in metres. */
function write({ context, camera, palette }: Brush, mapX = 0, mapY = 0, text: string, weight: number): void {
  const [x, y] = camera.toScreen(mapX, mapY);
  context.save();
  context.setTransform(camera.ratio, 0, 0, camera.ratio, x * camera.ratio, y * camera.ratio);
  context.font = `${weight} ${weight > 500 ? 13 : 11}px IBM Plex Mono, monospace`;
  context.lineWidth = 3;
  context.strokeStyle = palette.css.free;
  context.fillStyle = palette.css.ink;
  context.strokeText(text, 7, -6);
  context.fillText(text, 7, -6);
  context.restore();
}

function drawGraph({ context, camera, palette }: Brush, { regions, doors }: Rooms): void {
  context.strokeStyle = context.fillStyle = palette.css.ink;
  context.lineWidth = camera.px(1.2);
  context.globalAlpha = 0.6;
  context.beginPath();
  for (let i = 0; i + DOORWAY_STRIDE <= doors.length; i += DOORWAY_STRIDE) {
    for (const end of [DOORWAY.from, DOORWAY.to]) {
      const region = (doors[i + end] ?? 0) * REGION_STRIDE;
      context.moveTo(regions[region + REGION.x] ?? 0, regions[region + REGION.y] ?? 0);
      context.lineTo(doors[i + DOORWAY.x] ?? 0, doors[i + DOORWAY.y] ?? 0);
    }
  }
  context.stroke();
  context.globalAlpha = 1;
  for (let i = 0; i + REGION_STRIDE <= regions.length; i += REGION_STRIDE) {
    context.beginPath();
    context.arc(regions[i + REGION.x] ?? 0, regions[i + REGION.y] ?? 0, camera.px(4), 0, 2 * Math.PI);
    context.fill();
  }
  context.strokeStyle = palette.css.door;
  context.lineWidth = camera.px(3);
  for (let i = 0; i + DOORWAY_STRIDE <= doors.length; i += DOORWAY_STRIDE) {
    context.setLineDash(doors[i + DOORWAY.framed] ? [] : [camera.px(3), camera.px(3)]);
    context.beginPath();
    context.moveTo(doors[i + DOORWAY.x1] ?? 0, doors[i + DOORWAY.y1] ?? 0);
    context.lineTo(doors[i + DOORWAY.x2] ?? 0, doors[i + DOORWAY.y2] ?? 0);
    context.stroke();
  }
  context.setLineDash([]);
}

/** The outlines of the last answer, built once: they are drawn at every frame. */
const drawn: { of: Rooms | null; paths: readonly Path2D[] } = { of: null, paths: [] };

function pathsOf(found: Rooms): readonly Path2D[] {
  if (drawn.of === found) return drawn.paths;
  const paths = Array.from({ length: found.regions.length / REGION_STRIDE }, () => new Path2D());
  let corner = 0;
  for (let i = 0; i + 1 < found.rings.length; i += 2) {
    const [region, count] = [found.rings[i] ?? 0, found.rings[i + 1] ?? 0];
    paths[region]?.addPath(ring(found.corners, corner, count));
    corner += count;
  }
  Object.assign(drawn, { of: found, paths });
  return paths;
}

function ring(corners: Float32Array, first: number, count: number): Path2D {
  const path = new Path2D();
  for (let i = first; i < first + count; i += 1) path.lineTo(corners[2 * i] ?? 0, corners[2 * i + 1] ?? 0);
  path.closePath();
  return path;
}

/** The region that holds a map point; null outside of all. */
export function roomAt({ corners, rings }: Pick<Rooms, "corners" | "rings">, x: number, y: number): number | null {
  const crossings = new Map<number, number>();
  let first = 0;
  for (let k = 0; k + 1 < rings.length; k += 2) {
    const [region, count] = [rings[k] ?? 0, rings[k + 1] ?? 0];
    for (let i = 0; i < count; i += 1) {
      const [a, b] = [2 * (first + i), 2 * (first + ((i + 1) % count))];
      const [ax, ay, bx, by] = [corners[a] ?? 0, corners[a + 1] ?? 0, corners[b] ?? 0, corners[b + 1] ?? 0];
      // How often a ray to the right crosses the outlines of a region.
      if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) crossings.set(region, (crossings.get(region) ?? 0) + 1);
    }
    first += count;
  }
  for (const [region, count] of crossings) if (count % 2 === 1) return region;
  return null;
}
