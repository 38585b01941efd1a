// Maps beside that of the run: loaded ones where they were aligned (walls, trajectory, landmarks),
// and the walls of the bridge's own map.

import { type Brush, stroke } from "./layer.js";
import { drawPoints } from "./submaps.js";

/** Width of a piece of wall, radius of a landmark, CSS pixels. */
const WIDTH = 2.6;
const RADIUS = 5;

export function draw(brush: Brush): void {
  const { context, camera, palette } = brush;
  const colour = palette.css.prior;
  for (const { picture, alignment, shown } of brush.loadedMaps) {
    if (!shown || !alignment) continue;
    const { pose } = alignment;
    drawPoints(brush, picture.walls, pose, colour, WIDTH);
    context.save();
    context.translate(pose[0], pose[1]);
    context.rotate(pose[2]);
    stroke(brush, { colour, width: 1.2, alpha: 0.8, dash: [1, 4] }, () => {
      for (let i = 0; i + 1 < picture.way.length; i += 2) context.lineTo(picture.way[i] ?? 0, picture.way[i + 1] ?? 0);
    });
    for (let i = 0; i + 1 < picture.landmarks.length; i += 2) {
      stroke(brush, { colour, width: 1.8 }, () => context.arc(picture.landmarks[i] ?? 0, picture.landmarks[i + 1] ?? 0, camera.px(RADIUS), 0, 2 * Math.PI));
    }
    context.restore();
  }
  const { place, walls } = brush.bridgeMap;
  if (place) drawPoints(brush, walls, place, colour, WIDTH);
}
