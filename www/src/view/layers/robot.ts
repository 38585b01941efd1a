// The robot where it believes to be, with what of it touches walls at its true size, with the
// ellipse that holds 95 % of its position and the wedge of its heading; its true place and where
// its wheels alone would put it as outlines.

import { addBody } from "./body.js";
import type { Brush } from "./layer.js";

/** 95 % of a two-dimensional normal distribution: χ² with 2 degrees of freedom. */
const CHI2_95 = 5.991;
const SIGMAS_95 = 1.96;

export function draw(brush: Brush): void {
  const { context, camera, palette, scene, time } = brush;
  const { status } = scene;
  if (!status) return;
  outline(brush, status.odometryX, status.odometryY, status.odometryHeading, palette.css.odometry, [1.5, 3]);
  outline(brush, status.truthX, status.truthY, status.truthHeading, palette.css.truth, [5, 3]);

  const { x, y, heading } = status;
  const length = Math.max(status.halfLength, camera.px(9));
  context.fillStyle = context.strokeStyle = palette.css.estimate;

  const spread = SIGMAS_95 * Math.sqrt(Math.max(0, status.covHeading));
  if (spread < Math.PI / 2) {
    context.globalAlpha = 0.3;
    context.beginPath();
    context.moveTo(x, y);
    context.arc(x, y, length * 3, heading - spread, heading + spread);
    context.closePath();
    context.fill();
  }

  const axes = ellipseOf(status.covXx, status.covXy, status.covYy);
  const breath = camera.px(1.2 + 0.8 * Math.sin(time * 2.2));
  context.beginPath();
  context.ellipse(x, y, axes.major + breath, axes.minor + breath, axes.angle, 0, 2 * Math.PI);
  context.globalAlpha = 0.22;
  context.fill();
  context.globalAlpha = 1;
  context.lineWidth = camera.px(1.5);
  context.stroke();

  context.strokeStyle = palette.css.robot;
  context.lineWidth = camera.px(1);
  context.globalAlpha = 0.6;
  context.beginPath();
  addBody(brush, x, y, heading);
  context.stroke();
  context.globalAlpha = 1;

  body(brush, x, y, heading);
  context.fillStyle = palette.css.robot;
  context.fill();
  context.strokeStyle = palette.css.unknown;
  context.lineWidth = camera.px(1.5);
  context.stroke();
}

/** Half axes and direction of the 95 % ellipse. */
export function ellipseOf(xx: number, xy: number, yy: number): { major: number; minor: number; angle: number } {
  const mean = (xx + yy) / 2;
  const radius = Math.hypot((xx - yy) / 2, xy);
  return {
    major: Math.sqrt(CHI2_95 * Math.max(0, mean + radius)),
    minor: Math.sqrt(CHI2_95 * Math.max(0, mean - radius)),
    angle: 0.5 * Math.atan2(2 * xy, xx - yy),
  };
}

/** Its outline at a place that it is not believed to be at. */
export function outline(brush: Brush, x: number, y: number, heading: number, colour: string, dash: number[]): void {
  if (!Number.isFinite(x)) return;
  const { context, camera } = brush;
  body(brush, x, y, heading);
  context.strokeStyle = colour;
  context.lineWidth = camera.px(1.5);
  context.setLineDash(dash.map((length) => camera.px(length)));
  context.stroke();
  context.setLineDash([]);
}

/** An arrowhead with the size of the robot, never too small to see. */
function body({ context, camera, scene }: Brush, x: number, y: number, heading: number): void {
  const half = Math.max(scene.status?.halfLength ?? 0.1, camera.px(9));
  const wide = Math.max(scene.status?.halfWidth ?? 0.1, camera.px(7));
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  const to = (forward: number, left: number): [number, number] => [x + c * forward - s * left, y + s * forward + c * left];
  context.beginPath();
  context.moveTo(...to(half, 0));
  context.lineTo(...to(-half, wide));
  context.lineTo(...to(-half * 0.5, 0));
  context.lineTo(...to(-half, -wide));
  context.closePath();
}
