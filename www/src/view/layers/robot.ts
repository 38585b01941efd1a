// The robot at its estimated pose: the body that touches walls at its true size, the 95 % ellipse
// of its position and the wedge of its heading. Its true pose and its pose by odometry alone are
// outlines.

import type { Status } from "../../protocol/frame.js";
import { addBody, addShape } from "./body.js";
import { type Brush, stroke } from "./layer.js";

/** 95 % of a two-dimensional normal distribution: χ² with 2 degrees of freedom. */
export const CHI2_95 = 5.991;
const SIGMAS_95 = 1.96;
/** An ellipse longer than this, CSS pixels, is filled more and more faintly: otherwise a lost robot
    would be a cloud over its whole map. */
const FILLED = 150;

export function draw(brush: Brush): void {
  const { context, camera, palette, scene: { status } } = brush;
  if (!status) return;
  if (brush.byWheels) outline(brush, status.odometryX, status.odometryY, status.odometryHeading, palette.css.odometry, [1.5, 3]);
  if (brush.truth) outline(brush, status.truthX, status.truthY, status.truthHeading, palette.css.truth, [5, 3]);

  const { x, y, heading } = status;
  const length = Math.max(status.halfLength, camera.px(9));
  context.fillStyle = palette.css.estimate;

  // If a robot may be in several places, the hypotheses are drawn instead.
  const isBelieved = status.localisation === null || status.localisation === "localised";
  const spread = SIGMAS_95 * Math.sqrt(Math.max(0, status.covHeading));
  if (isBelieved && spread < Math.PI / 2) {
    context.globalAlpha = 0.3;
    context.beginPath();
    context.moveTo(x, y);
    context.arc(x, y, length * 3, heading - spread, heading + spread);
    context.closePath();
    context.fill();
  }

  if (isBelieved) drawEllipse(brush, status);

  stroke(brush, { colour: palette.css.robot, width: 1, alpha: 0.6 }, () => addBody(brush, x, y, heading));
  context.globalAlpha = 1;
  context.fillStyle = palette.css.robot;
  context.beginPath();
  addArrow(brush, x, y, heading);
  context.fill();
  stroke(brush, { colour: palette.css.unknown, width: 1.5 }, () => addArrow(brush, x, y, heading));
}

/** The 95 % ellipse of its position. */
function drawEllipse(brush: Brush, { x, y, covXx, covXy, covYy }: Status): void {
  const { context, camera, palette, time } = brush;
  const axes = ellipseOf(covXx, covXy, covYy);
  const breath = camera.px(1.2 + 0.8 * Math.sin(time * 2.2));
  const addEllipse = (): void => context.ellipse(x, y, axes.major + breath, axes.minor + breath, axes.angle, 0, 2 * Math.PI);
  context.globalAlpha = 0.22 * Math.min(1, camera.px(FILLED) / axes.major);
  context.beginPath();
  addEllipse();
  context.fill();
  stroke(brush, { colour: palette.css.estimate, width: 1.5 }, addEllipse);
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

/** Its outline at a pose other than the estimate. */
export function outline(brush: Brush, x: number, y: number, heading: number, colour: string, dash: readonly number[]): void {
  if (!Number.isFinite(x)) return;
  stroke(brush, { colour, width: 1.5, dash }, () => addArrow(brush, x, y, heading));
}

/** An arrowhead of the robot's size, but never too small to see. */
function addArrow({ context, camera, scene }: Brush, x: number, y: number, heading: number): void {
  const half = Math.max(scene.status?.halfLength ?? 0.1, camera.px(9));
  const wide = Math.max(scene.status?.halfWidth ?? 0.1, camera.px(7));
  addShape(context, x, y, heading, [[half, 0], [-half, wide], [-half * 0.5, 0], [-half, -wide]]);
}
