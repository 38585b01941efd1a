// Draws the layers that are switched on, from the ground up.

import type { Box, Camera } from "./camera.js";
import type { LayerName } from "./scene.js";
import * as chosen from "./layers/chosen.js";
import * as closures from "./layers/closures.js";
import * as compared from "./layers/compared.js";
import * as contest from "./layers/contest.js";
import * as doors from "./layers/doors.js";
import * as edits from "./layers/edits.js";
import * as geofence from "./layers/geofence.js";
import * as found from "./layers/found.js";
import * as frontiers from "./layers/frontiers.js";
import * as graph from "./layers/graph.js";
import * as grid from "./layers/grid.js";
import type { Brush } from "./layers/layer.js";
import * as hypotheses from "./layers/hypotheses.js";
import * as landmarks from "./layers/landmarks.js";
import * as points from "./layers/points.js";
import * as priorMap from "./layers/prior_map.js";
import * as lines from "./layers/lines.js";
import * as loadedMaps from "./layers/loaded_maps.js";
import * as path from "./layers/path.js";
import * as robot from "./layers/robot.js";
import * as rooms from "./layers/rooms.js";
import * as scan from "./layers/scan.js";
import * as spot from "./layers/spot.js";
import * as submaps from "./layers/submaps.js";
import * as torn from "./layers/torn.js";
import * as trails from "./layers/trails.js";
import * as tree from "./layers/tree.js";
import * as truth from "./layers/truth.js";
import { TruthPicture } from "./layers/truth_picture.js";
import * as twin from "./layers/twin.js";
import * as tracks from "./layers/tracks.js";
import * as walls from "./layers/walls.js";
import * as wheels from "./layers/wheels.js";

export type Switches = Readonly<Record<LayerName, boolean>>;

const truthPicture = new TruthPicture();

/** The ground: changes only with the map and the camera. `within`: only this part of the map. */
export function drawGround(brush: Brush, on: Switches, within: Box | null): void {
  const { context, camera } = brush;
  context.save();
  if (within && Number.isFinite(within.minX)) clip(context, camera, within);
  clear(brush);
  if (on.grid) paint(brush, grid.draw);
  if (on.wheels) paint(brush, wheels.draw);
  paint(brush, grid.drawRules);
  if (on.truth) paint(brush, (brush) => truthPicture.draw(brush));
  context.restore();
}

/** To whole pixels, and those beside them, into which smoothing carries. */
function clip(context: CanvasRenderingContext2D, camera: Camera, { minX, minY, maxX, maxY }: Box): void {
  const [left, top] = camera.toScreen(minX, maxY).map((at) => Math.floor(at * camera.ratio) - 2) as [number, number];
  const [right, bottom] = camera.toScreen(maxX, minY).map((at) => Math.ceil(at * camera.ratio) + 2) as [number, number];
  context.resetTransform();
  context.beginPath();
  context.rect(left, top, right - left, bottom - top);
  context.clip();
}

type Layer = readonly [LayerName, (brush: Brush) => void];

/** What grows with a run: many long lines, which cost most of all. */
const RECORD: readonly Layer[] = [
  ["submaps", submaps.drawWalls],
  ["compared", compared.draw],
  ["trails", trails.draw],
  ["graph", graph.draw],
  ["closures", closures.draw],
  ["submaps", submaps.drawNumbers],
];

/** Everything that was recorded. */
export function drawRecord(brush: Brush, on: Switches): void {
  clear(brush);
  const { submaps: { ahead } } = brush.scene;
  // The walls go ahead of a grid that is still to be drawn again.
  if (ahead && on.grid && !on.submaps) paint(brush, submaps.drawAll);
  for (const [name, draw] of RECORD) if (on[name]) paint(brush, draw);
}

const OVERLAYS: readonly Layer[] = [
  ["rooms", rooms.draw],
  ["truth", truth.drawMovers],
  ["truth", doors.draw],
  ["priorMap", priorMap.draw],
  ["hypotheses", hypotheses.draw],
  ["frontiers", frontiers.draw],
  ["lines", lines.draw],
  ["walls", walls.draw],
  ["landmarks", landmarks.draw],
  ["tree", tree.draw],
  ["scan", scan.draw],
  ["tracks", tracks.draw],
  ["found", found.draw],
  ["points", points.draw],
  ["rawPath", path.drawRaw],
  ["path", path.draw],
  ["trails", trails.drawEnd],
  ["twin", twin.draw],
  ["torn", torn.draw],
  ["robot", robot.draw],
];

/** Everything that moves. */
export function drawOverlays(brush: Brush, on: Switches): void {
  clear(brush);
  // Two plans at once are none: the robot's own makes room for the contest.
  const isHidden = (name: LayerName): boolean => brush.contest !== null && ["frontiers", "tree", "rawPath", "path"].includes(name);
  for (const [name, draw] of OVERLAYS) {
    if (on[name] && !isHidden(name)) paint(brush, WITH_ROBOT.has(name) ? (brush) => withRobot(brush, draw) : draw);
  }
  paint(brush, loadedMaps.draw);
  paint(brush, geofence.draw);
  paint(brush, contest.draw);
  paint(brush, edits.draw);
  paint(brush, spot.draw);
  paint(brush, chosen.draw);
}

/** What stands on the newest submap, and glides with it. */
const WITH_ROBOT: ReadonlySet<LayerName> = new Set(["scan", "tracks", "found", "points", "robot"]);

function withRobot(brush: Brush, draw: (brush: Brush) => void): void {
  const { submaps } = brush.scene;
  const shift = submaps.shift(submaps.count - 1);
  if (shift) brush.context.transform(shift.cos, shift.sin, -shift.sin, shift.cos, shift.dx, shift.dy);
  draw(brush);
}

/** A layer leaves the context as it was. */
function paint(brush: Brush, draw: (brush: Brush) => void): void {
  brush.context.save();
  brush.camera.applyTo(brush.context);
  draw(brush);
  brush.context.restore();
}

function clear({ context }: Brush): void {
  context.resetTransform();
  context.clearRect(0, 0, context.canvas.width, context.canvas.height);
}
