// Uncertainty of the line features: the band that contains 95 % of the lines which the covariance
// allows.
//
// A point p = r n + t u of the line (n its normal, u = dn/dα) is displaced by δd = t δα - δr across
// it, so var d = t² var α - 2 t cov(α, r) + var r: a band that is narrow where the wall was
// observed well and widens away from there.

import { LINE, LINE_STRIDE } from "../../protocol/module.js";
import { isOutside } from "../camera.js";
import type { PathPencil } from "../painter.js";
import { addSegments, type Brush, stroke } from "./layer.js";

const SIGMAS = 1.96;
const STATIONS = 8;
/** Opacity of the bands of recognised walls, of other walls, and of features not known to be
    walls. */
const STRENGTHS = [{ inside: 0.42, edge: 0.9 }, { inside: 0.2, edge: 0.45 }, { inside: 0.1, edge: 0.3 }] as const;

/** A line with its observed part, t1 to t2, and the σ of its displacement at t. */
interface Seen { readonly n: readonly [number, number]; readonly r: number; readonly t: readonly [number, number]; readonly sigmaAt: (t: number) => number }

export function draw(brush: Brush): void {
  const { context, camera, palette, scene: { lines } } = brush;
  const least = camera.px(1);
  const view = camera.visible;
  // Bands that are nowhere wider than a line are drawn as lines, all at once.
  const thin = STRENGTHS.map((): number[] => []);
  context.fillStyle = context.strokeStyle = palette.css.lines;
  context.lineWidth = least;
  for (let i = 0; i + LINE_STRIDE <= lines.length; i += LINE_STRIDE) {
    const place = lines[i + LINE.confirmed] ? (lines[i + LINE.matched] ? 0 : 1) : 2;
    const line = seenOf(lines.subarray(i, i + LINE_STRIDE));
    const [x1, y1] = at(line, line.r, line.t[0]);
    const [x2, y2] = at(line, line.r, line.t[1]);
    // The variance is convex in t: it is largest at an end.
    const half = SIGMAS * Math.max(line.sigmaAt(line.t[0]), line.sigmaAt(line.t[1]));
    if (isOutside(view, x1, y1, x2, y2, half + 2 * least)) continue;
    if (half <= least) {
      thin[place]?.push(x1, y1, x2, y2);
      continue;
    }
    context.beginPath();
    addBand(context, line, least);
    context.globalAlpha = STRENGTHS[place]?.inside ?? 0;
    context.fill();
    context.globalAlpha = STRENGTHS[place]?.edge ?? 0;
    context.stroke();
  }
  STRENGTHS.forEach(({ edge }, place) => stroke(brush, { colour: palette.css.lines, width: 3, alpha: edge }, () => addSegments(context, thin[place] ?? [])));
}

function seenOf(row: Float64Array): Seen {
  const [alpha = 0, r = 0, varAlpha = 0, covAlphaR = 0, varR = 0, x1 = 0, y1 = 0, x2 = 0, y2 = 0] = row;
  const [nx, ny] = [Math.cos(alpha), Math.sin(alpha)];
  const along = (x: number, y: number): number => -ny * x + nx * y;
  return { n: [nx, ny], r, t: [along(x1, y1), along(x2, y2)], sigmaAt: (t) => Math.sqrt(Math.max(0, t * t * varAlpha - 2 * t * covAlphaR + varR)) };
}

/** The point d along the normal and t along the line, m. */
function at({ n: [nx, ny] }: Seen, d: number, t: number): [number, number] {
  return [nx * d - ny * t, ny * d + nx * t];
}

function addBand(context: PathPencil, line: Seen, least: number): void {
  const { r, t: [t1, t2], sigmaAt } = line;
  const edge = (sign: 1 | -1, k: number): void => {
    const t = t1 + ((t2 - t1) * k) / STATIONS;
    context.lineTo(...at(line, r + sign * Math.max(SIGMAS * sigmaAt(t), least), t));
  };
  for (let k = 0; k <= STATIONS; k += 1) edge(1, k);
  for (let k = STATIONS; k >= 0; k -= 1) edge(-1, k);
  context.closePath();
}
