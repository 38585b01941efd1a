// What is drawn, from the bottom up, and on which sheet: the layers in the order that a person
// chose.
//
// A sheet is drawn as rarely as the slowest of its parts allows. A part that lies over a part of a
// quick sheet moves to that sheet, or it would end up below it.

import type { Brush } from "./layers/layer.js";
import { LAYERS, type LayerName } from "./scene.js";
import { SHEETS, type SheetName } from "./surface.js";
import * as chosen from "./layers/chosen.js";
import * as closures from "./layers/closures.js";
import * as compared from "./layers/compared.js";
import * as contest from "./layers/contest.js";
import * as doors from "./layers/doors.js";
import * as edits from "./layers/edits.js";
import * as found from "./layers/found.js";
import * as geofence from "./layers/geofence.js";
import * as frontiers from "./layers/frontiers.js";
import * as graph from "./layers/graph.js";
import * as grid from "./layers/grid.js";
import * as hypotheses from "./layers/hypotheses.js";
import * as landmarks from "./layers/landmarks.js";
import * as lines from "./layers/lines.js";
import * as loadedMaps from "./layers/loaded_maps.js";
import * as path from "./layers/path.js";
import * as points from "./layers/points.js";
import * as priorMap from "./layers/prior_map.js";
import * as robot from "./layers/robot.js";
import * as rooms from "./layers/rooms.js";
import * as scan from "./layers/scan.js";
import * as spot from "./layers/spot.js";
import * as submaps from "./layers/submaps.js";
import * as torn from "./layers/torn.js";
import * as tracks from "./layers/tracks.js";
import * as trails from "./layers/trails.js";
import * as tree from "./layers/tree.js";
import * as truth from "./layers/truth.js";
import * as twin from "./layers/twin.js";
import * as walls from "./layers/walls.js";
import * as wheels from "./layers/wheels.js";

export type Switches = Readonly<Record<LayerName, boolean>>;

interface Part {
  readonly layer: LayerName;
  readonly sheet: SheetName;
  readonly draw: (brush: Brush) => void;
  /** Whether it is drawn, if that depends on more than the switch of its layer. */
  readonly isOn?: (on: Switches, brush: Brush) => boolean;
  /** It is attached to the newest submap, and glides with it. */
  readonly onRobot?: boolean;
  /** It shows what the robot itself is about to do. */
  readonly ofPlan?: boolean;
}

/** Two plans at once would be confusing: the robot's own makes room for the contest. */
const ofPlan = (layer: LayerName, draw: Part["draw"]): Part => ({ layer, sheet: "overlays", draw, ofPlan: true, isOn: (on, { contest }) => on[layer] && contest === null });
const ofRobot = (layer: LayerName, draw: Part["draw"]): Part => ({ layer, sheet: "overlays", draw, onRobot: true });

/** From the bottom up, by default. */
const PARTS: readonly Part[] = [
  { layer: "grid", sheet: "ground", draw: grid.draw },
  { layer: "wheels", sheet: "ground", draw: wheels.draw },
  { layer: "grid", sheet: "ground", draw: grid.drawRules, isOn: () => true },
  { layer: "truth", sheet: "ground", draw: truth.drawWalls },
  { layer: "submaps", sheet: "record", draw: submaps.drawWalls },
  // The walls move first; the grid is redrawn later.
  { layer: "submaps", sheet: "record", draw: submaps.drawAll, isOn: (on, { scene }) => scene.submaps.ahead && on.grid && !on.submaps },
  { layer: "compared", sheet: "record", draw: compared.draw },
  { layer: "trails", sheet: "record", draw: trails.draw },
  { layer: "graph", sheet: "record", draw: graph.draw },
  { layer: "closures", sheet: "record", draw: closures.draw },
  { layer: "submaps", sheet: "record", draw: submaps.drawNumbers },
  { layer: "rooms", sheet: "overlays", draw: rooms.draw },
  { layer: "truth", sheet: "overlays", draw: truth.drawMovers },
  { layer: "truth", sheet: "overlays", draw: doors.draw },
  { layer: "priorMap", sheet: "overlays", draw: priorMap.draw },
  { layer: "hypotheses", sheet: "overlays", draw: hypotheses.draw },
  ofPlan("frontiers", frontiers.draw),
  { layer: "lines", sheet: "overlays", draw: lines.draw },
  { layer: "walls", sheet: "overlays", draw: walls.draw },
  { layer: "landmarks", sheet: "overlays", draw: landmarks.draw },
  ofPlan("tree", tree.draw),
  ofRobot("scan", scan.draw),
  ofRobot("tracks", tracks.draw),
  ofRobot("found", found.draw),
  ofRobot("points", points.draw),
  ofPlan("rawPath", path.drawRaw),
  ofPlan("path", path.draw),
  { layer: "trails", sheet: "overlays", draw: trails.drawEnd },
  { layer: "twin", sheet: "overlays", draw: twin.draw },
  { layer: "torn", sheet: "overlays", draw: torn.draw },
  ofRobot("robot", robot.draw),
];

/** Whether a layer makes room while planners are compared. */
export const isOfPlan = (layer: LayerName): boolean => PARTS.some((part) => part.layer === layer && part.ofPlan);

/** Over all layers: what somebody is working on. */
const ON_TOP = [loadedMaps.draw, geofence.draw, contest.draw, edits.draw, spot.draw, chosen.draw] as const;

/** Where the parts of each layer begin: LAYERS have that order. */
const isFirst = (part: Part, at: number): boolean => PARTS.findIndex(({ layer }) => layer === part.layer) === at;

/** The parts for an order of layers. The first part of a layer is drawn at the layer's place. Its
    other parts stay where they are, over some other layer, unless their own layer was lifted over
    that. */
function arranged(order: readonly LayerName[]): readonly Part[] {
  const rank = new Map(order.map((layer, at) => [layer, at]));
  const above = new Map<LayerName, Part[]>(order.map((layer) => [layer, []]));
  let under: LayerName = LAYERS[0];
  PARTS.forEach((part, at) => {
    const { layer } = part;
    if (isFirst(part, at)) {
      under = layer;
      above.get(layer)?.unshift(part);
    } else above.get((rank.get(layer) ?? 0) < (rank.get(under) ?? 0) ? under : layer)?.push(part);
  });
  return order.flatMap((layer) => above.get(layer) ?? []);
}

let [lastOrder, lastParts] = [LAYERS as readonly LayerName[], arranged(LAYERS)];

function partsIn(order: readonly LayerName[]): readonly Part[] {
  if (order !== lastOrder) [lastOrder, lastParts] = [order, arranged(order)];
  return lastParts;
}

/** Draws the parts of a sheet, in an order of layers. */
export function drawSheet(sheet: SheetName, brush: Brush, on: Switches, order: readonly LayerName[]): void {
  let lowest = 0;
  for (const { layer, sheet: own, draw, isOn, onRobot } of partsIn(order)) {
    if (!(isOn ? isOn(on, brush) : on[layer])) continue;
    lowest = Math.max(lowest, SHEETS.indexOf(own));
    if (SHEETS[lowest] === sheet) paint(brush, onRobot ? () => withRobot(brush, draw) : draw);
  }
  if (sheet === "overlays") for (const draw of ON_TOP) paint(brush, draw);
}

function withRobot(brush: Brush, draw: (brush: Brush) => void): void {
  const { submaps } = brush.scene;
  const shift = submaps.shift(submaps.count - 1);
  if (shift) brush.context.transform(shift.cos, shift.sin, -shift.sin, shift.cos, shift.dx, shift.dy);
  draw(brush);
}

/** Draws a layer, and restores the context. */
function paint(brush: Brush, draw: (brush: Brush) => void): void {
  brush.context.save();
  brush.camera.applyTo(brush.context);
  draw(brush);
  brush.context.restore();
}
