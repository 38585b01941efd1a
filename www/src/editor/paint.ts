// Paints a drawing on a canvas: the grid, its parts, what is chosen and what is being drawn.

import { colourOf } from "../ui/plot_style.js";
import type { Camera } from "../view/camera.js";
import { type Handle } from "./change.js";
import { type Drawing, type Part, partAt, type PartRef, partsOf, type Point, sameRef } from "./drawing.js";
import { distance, lineOf, MARK_RADIUS, plus, turned } from "./outline.js";
import { gridOf, type Snapped } from "./snap.js";

const NAMES = ["map-occupied", "map-glass", "map-dark", "map-door", "map-people", "map-robot", "map-path", "line", "line-strong", "ink", "raised", "accent", "warn", "sunk"] as const;
export type Colours = Readonly<Record<(typeof NAMES)[number], string>>;

export function coloursOf(probe: HTMLElement): Colours {
  return Object.fromEntries(NAMES.map((name) => [name, colourOf(probe, name)])) as Record<(typeof NAMES)[number], string>;
}

export interface Picture {
  readonly drawing: Drawing;
  readonly chosen: PartRef | null;
  readonly wrong: PartRef | null;
  readonly handles: readonly Handle[];
  /** The part being drawn, as it would become. */
  readonly draft: Part | null;
  readonly points: readonly Point[];
  /** Where the next point would be. */
  readonly cursor: Snapped | null;
  readonly measure: string;
}

export function paint(context: CanvasRenderingContext2D, camera: Camera, colours: Colours, picture: Picture): void {
  context.setTransform(camera.ratio, 0, 0, camera.ratio, 0, 0);
  context.fillStyle = colours.sunk;
  context.fillRect(0, 0, camera.width, camera.height);
  context.lineCap = context.lineJoin = "round";
  paintGrid(context, camera, colours);
  const parts = partsOf(picture.drawing).flatMap((ref) => {
    const part = partAt(picture.drawing, ref);
    return part ? [{ ref, part }] : [];
  });
  // Outlines of all solids come first and their interiors last: where solids overlap or touch, no
  // line separates them, just as none separates the walls of a building.
  const isSolid = ({ part }: (typeof parts)[number]): boolean => part.kind === "obstacle" && part.value.shape !== "polyline";
  const [solids, others] = [parts.filter(isSolid), parts.filter((each) => !isSolid(each))];
  const paintOutline = ({ ref, part }: (typeof parts)[number]): void => {
    const halo = sameRef(ref, picture.wrong) ? colours.warn : sameRef(ref, picture.chosen) ? colours.accent : null;
    if (halo) paintPart(context, camera, part, colours, halo);
    paintPart(context, camera, part, colours, null);
  };
  solids.forEach(paintOutline);
  for (const { part } of solids) fillPart(context, camera, part, colours);
  others.forEach(paintOutline);
  for (const { ref, part } of parts) if (sameRef(ref, picture.chosen)) paintLengths(context, camera, part, colours);
  if (picture.draft) {
    context.globalAlpha = 0.7;
    paintPart(context, camera, picture.draft, colours, null);
    if (picture.draft.kind === "obstacle" && picture.draft.value.shape !== "polyline") fillPart(context, camera, picture.draft, colours);
    context.globalAlpha = 1;
    paintLengths(context, camera, picture.draft, colours);
  }
  for (const point of picture.points) dot(context, camera, point, 4, colours.accent, colours.raised);
  for (const { at, what } of picture.handles) dot(context, camera, at, 6, what === "corner" ? colours.raised : colours.accent, colours.accent);
  if (picture.cursor) paintCursor(context, camera, colours, picture.cursor, picture.measure);
}

function paintGrid(context: CanvasRenderingContext2D, camera: Camera, colours: Colours): void {
  const { minX, maxX, minY, maxY } = camera.visible;
  const cell = gridOf(camera.scale);
  const rules = (step: number, alpha: number): void => {
    context.beginPath();
    for (let x = Math.ceil(minX / step) * step; x <= maxX; x += step) line(context, camera, [x, minY], [x, maxY]);
    for (let y = Math.ceil(minY / step) * step; y <= maxY; y += step) line(context, camera, [minX, y], [maxX, y]);
    context.globalAlpha = alpha;
    context.strokeStyle = colours.line;
    context.lineWidth = 1;
    context.stroke();
    context.globalAlpha = 1;
  };
  if (cell * camera.scale >= 7) rules(cell, 0.45);
  rules(camera.scale >= 14 ? 1 : 5, 1);
}

/** Begins the path of a part. Returns its first point, or null if it has none. */
function trace(context: CanvasRenderingContext2D, camera: Camera, part: Part): [number, number] | null {
  const { points, closed, radius } = lineOf(part);
  const at = points.map((point) => camera.toScreen(...point));
  const [first] = at;
  if (!first) return null;
  context.beginPath();
  for (const point of at) context.lineTo(...point);
  if (closed) context.closePath();
  if (part.kind === "start" || part.kind === "goal" || (part.kind === "obstacle" && radius > 0)) {
    context.beginPath();
    context.arc(...first, Math.max(radius * camera.scale, 2), 0, 2 * Math.PI);
  }
  return first;
}

/** Fills the interior of a solid part, over whatever is drawn there. */
function fillPart(context: CanvasRenderingContext2D, camera: Camera, part: Part, colours: Colours): void {
  if (!trace(context, camera, part)) return;
  context.save();
  context.fillStyle = colours.sunk;
  context.fill();
  context.fillStyle = colourOfPart(part, colours);
  context.globalAlpha *= 0.28;
  context.fill();
  context.restore();
}

/** With a halo, draws only a broad outline. */
function paintPart(context: CanvasRenderingContext2D, camera: Camera, part: Part, colours: Colours, halo: string | null): void {
  const first = trace(context, camera, part);
  if (!first) return;
  const { points, radius } = lineOf(part);
  context.save();
  if (halo) {
    context.strokeStyle = halo;
    context.globalAlpha = 0.45;
    context.lineWidth = 11;
    context.stroke();
    context.restore();
    return;
  }
  const colour = colourOfPart(part, colours);
  context.strokeStyle = context.fillStyle = colour;
  context.lineWidth = 3;
  switch (part.kind) {
    case "obstacle":
      // The interior of a solid covers the inner half of its outline.
      if (part.value.shape !== "polyline") context.lineWidth = 5;
      if (part.value.material === "glass") context.setLineDash([9, 5]);
      context.stroke();
      break;
    case "door":
      context.lineWidth = 5;
      if (part.value.open) context.setLineDash([3, 7]);
      context.stroke();
      break;
    case "mover":
      context.lineWidth = 1.6;
      context.setLineDash([5, 5]);
      context.stroke();
      context.setLineDash([]);
      context.beginPath();
      context.arc(...first, Math.max(radius * camera.scale, 3), 0, 2 * Math.PI);
      context.globalAlpha *= 0.5;
      context.fill();
      break;
    case "start": {
      context.stroke();
      const place = points[0] as Point;
      const ahead = plus(place, turned([2 * MARK_RADIUS, 0], part.value.heading ?? 0));
      context.beginPath();
      line(context, camera, place, ahead);
      context.stroke();
      break;
    }
    case "goal":
      context.stroke();
      context.beginPath();
      context.arc(...first, 3, 0, 2 * Math.PI);
      context.fill();
  }
  context.restore();
}

function colourOfPart(part: Part, colours: Colours): string {
  switch (part.kind) {
    case "door": return colours["map-door"];
    case "mover": return colours["map-people"];
    case "start": return colours["map-robot"];
    case "goal": return colours["map-path"];
    case "obstacle": return colours[part.value.material === "glass" ? "map-glass" : part.value.material === "dark" ? "map-dark" : "map-occupied"];
  }
}

/** Lengths of its sides, m, where there is room for them. */
function paintLengths(context: CanvasRenderingContext2D, camera: Camera, part: Part, colours: Colours): void {
  const { points, closed, radius } = lineOf(part);
  if (part.kind === "start" || part.kind === "goal" || points.length > 60) return;
  if (radius > 0 && part.kind === "obstacle") return label(context, colours, `r ${radius.toFixed(2)} m`, camera.toScreen(...(points[0] as Point)));
  const isBox = part.kind === "obstacle" && part.value.shape === "rectangle";
  // Two sides describe a box.
  const ends = isBox ? points.slice(0, 2) : closed ? points : points.slice(0, -1);
  ends.forEach((a, i) => {
    const b = points[(i + 1) % points.length] as Point;
    const length = distance(a, b);
    if (length * camera.scale < 44) return;
    label(context, colours, `${length.toFixed(2)} m`, camera.toScreen((a[0] + b[0]) / 2, (a[1] + b[1]) / 2));
  });
}

function paintCursor(context: CanvasRenderingContext2D, camera: Camera, colours: Colours, { point, to }: Snapped, measure: string): void {
  const [x, y] = camera.toScreen(...point);
  context.strokeStyle = colours.accent;
  context.lineWidth = 1.6;
  context.beginPath();
  if (to === "end") context.rect(x - 7, y - 7, 14, 14);
  else {
    context.moveTo(x - 9, y);
    context.lineTo(x + 9, y);
    context.moveTo(x, y - 9);
    context.lineTo(x, y + 9);
  }
  context.stroke();
  if (to === "angle") {
    context.beginPath();
    context.arc(x, y, 6, 0, 2 * Math.PI);
    context.stroke();
  }
  if (measure) label(context, colours, measure, [x, y - 26]);
}

function label(context: CanvasRenderingContext2D, colours: Colours, text: string, [x, y]: readonly [number, number]): void {
  context.font = "500 12px IBM Plex Mono, monospace";
  context.textAlign = "center";
  context.textBaseline = "middle";
  const width = context.measureText(text).width + 12;
  context.fillStyle = colours.raised;
  context.globalAlpha = 0.92;
  context.beginPath();
  context.roundRect(x - width / 2, y - 10, width, 20, 6);
  context.fill();
  context.globalAlpha = 1;
  context.fillStyle = colours.ink;
  context.fillText(text, x, y + 0.5);
}

function dot(context: CanvasRenderingContext2D, camera: Camera, point: Point, size: number, fill: string, stroke: string): void {
  context.beginPath();
  context.arc(...camera.toScreen(...point), size, 0, 2 * Math.PI);
  context.fillStyle = fill;
  context.fill();
  context.strokeStyle = stroke;
  context.lineWidth = 2;
  context.stroke();
}

function line(context: CanvasRenderingContext2D, camera: Camera, from: Point, to: Point): void {
  context.moveTo(...camera.toScreen(...from));
  context.lineTo(...camera.toScreen(...to));
}
