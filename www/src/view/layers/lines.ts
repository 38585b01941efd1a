// Uncertainty of the line features: the band in which 95 % of the lines lie that the covariance
// allows.
//
// A point p = r n + t u of the line (n its normal, u = dn/dα) is displaced by δd = t δα - δr across
// it, so var d = t² var α - 2 t cov(α, r) + var r: a band that is narrow where the wall was seen
// well and opens away from there.

import { LINE, LINE_STRIDE } from "../../protocol/module.js";
import type { Brush } from "./layer.js";

const SIGMAS = 1.96;
const STATIONS = 8;

export function draw({ context, camera, palette, scene }: Brush): void {
  const { lines } = scene;
  context.fillStyle = context.strokeStyle = palette.css.lines;
  context.lineWidth = camera.px(1);
  for (let i = 0; i + LINE_STRIDE <= lines.length; i += LINE_STRIDE) {
    context.beginPath();
    addBand(context, lines.subarray(i, i + LINE_STRIDE), camera.px(1));
    context.globalAlpha = lines[i + LINE.confirmed] ? (lines[i + LINE.matched] ? 0.42 : 0.2) : 0.1;
    context.fill();
    context.globalAlpha = lines[i + LINE.confirmed] ? (lines[i + LINE.matched] ? 0.9 : 0.45) : 0.3;
    context.stroke();
  }
}

function addBand(context: CanvasRenderingContext2D, line: Float64Array, least: number): void {
  const [alpha = 0, r = 0, varAlpha = 0, covAlphaR = 0, varR = 0, x1 = 0, y1 = 0, x2 = 0, y2 = 0] = line;
  const [nx, ny] = [Math.cos(alpha), Math.sin(alpha)];
  const along = (x: number, y: number): number => -ny * x + nx * y;
  const [t1, t2] = [along(x1, y1), along(x2, y2)];
  const edge = (sign: 1 | -1, k: number): void => {
    const t = t1 + ((t2 - t1) * k) / STATIONS;
    const sigma = Math.sqrt(Math.max(0, t * t * varAlpha - 2 * t * covAlphaR + varR));
    const d = r + sign * Math.max(SIGMAS * sigma, least);
    context.lineTo(nx * d - ny * t, ny * d + nx * t);
  };
  for (let k = 0; k <= STATIONS; k += 1) edge(1, k);
  for (let k = STATIONS; k >= 0; k -= 1) edge(-1, k);
  context.closePath();
}
