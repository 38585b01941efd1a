// Tracks of moving things: the 95 % ellipse of the position, the velocity and the number; and the
// hits on them, which were taken out of pose and map.

import { TRACK, TRACK_STRIDE, type TrackMotionName } from "../../protocol/module.js";
import { type Brush, label, stroke } from "./layer.js";
import { writeName } from "./name.js";
import { ellipseOf } from "./robot.js";

/** In the order of the module. */
const MOTIONS = ["new", "moving", "paused", "standing"] as const satisfies readonly TrackMotionName[];
/** Seconds of motion that the arrow shows. */
const AHEAD = 1;

export interface Track {
  readonly id: number;
  readonly x: number;
  readonly y: number;
  readonly motion: TrackMotionName;
}

/** The tracks of a flat array. */
export function tracksOf(tracks: Float32Array): Track[] {
  const rows = Array.from({ length: tracks.length / TRACK_STRIDE }, (_, row) => row * TRACK_STRIDE);
  return rows.map((row) => {
    const at = (place: number): number => tracks[row + place] ?? NaN;
    return { id: at(TRACK.id), x: at(TRACK.x), y: at(TRACK.y), motion: MOTIONS[at(TRACK.motion)] ?? "new" };
  });
}

export function draw(brush: Brush): void {
  const { context, camera, palette, scene: { tracks, takenOut } } = brush;
  context.fillStyle = palette.css.moving;
  const size = Math.max(camera.px(3.5), 0.03);
  context.beginPath();
  for (let i = 0; i + 1 < takenOut.length; i += 2) context.rect((takenOut[i] ?? 0) - size / 2, (takenOut[i + 1] ?? 0) - size / 2, size, size);
  context.fill();
  tracksOf(tracks).forEach((track, row) => {
    // A thing that has stood for long is part of the map.
    if (track.motion !== "standing") drawTrack(brush, track, tracks.subarray(row * TRACK_STRIDE));
  });
}

function drawTrack(brush: Brush, { id, x, y, motion }: Track, row: Float32Array): void {
  const { context, camera, palette } = brush;
  const at = (place: number): number => row[place] ?? NaN;
  const { major, minor, angle } = ellipseOf(at(TRACK.varX), at(TRACK.covXy), at(TRACK.varY));
  const moves = motion === "moving";
  const pen = { colour: palette.css.moving, width: 1.8, alpha: at(TRACK.seen) ? 1 : 0.55, dash: moves ? [] : [3, 3] };
  stroke(brush, pen, () => context.ellipse(x, y, major, minor, angle, 0, 2 * Math.PI));
  if (!moves) return;
  const [dx, dy] = [at(TRACK.velocityX) * AHEAD, at(TRACK.velocityY) * AHEAD];
  const barb = (turn: number): void => {
    const [direction, length] = [Math.atan2(dy, dx) + turn, camera.px(7)];
    context.moveTo(x + dx, y + dy);
    context.lineTo(x + dx + length * Math.cos(direction), y + dy + length * Math.sin(direction));
  };
  stroke(brush, { ...pen, width: 2 }, () => {
    context.moveTo(x, y);
    context.lineTo(x + dx, y + dy);
    barb(2.6);
    barb(-2.6);
  });
  label(brush, x, y, () => writeName(brush, `${id}`, palette.css.moving));
}
