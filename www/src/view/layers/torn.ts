// Where the map is torn: a red ring with a cross, and how far its sides are apart. Dashed, without
// a cross, where nothing proves the relative place of its parts. Of labels that would overlap, only
// that of the widest tear is written.

import type { Tear } from "../../protocol/module.js";
import { fixed } from "../../ui/format.js";
import { called } from "../../ui/tears.js";
import { t } from "../../words.js";
import { type Brush, label, stroke } from "./layer.js";

/** Radius of a ring, CSS pixels. */
const RADIUS = 13;
/** Half the side of the cross, CSS pixels. */
const CROSS = 5;
/** From the middle of a mark to its label, and between two lines of a label, CSS pixels. */
const BESIDE = RADIUS + 5;
const LINE = 15;

export function draw(brush: Brush): void {
  const { context, camera, palette, tears, thing } = brush;
  const torn = thing?.kind === "torn" ? thing.tear : null;
  for (const tear of tears) {
    const { kind, place: [x, y] } = tear;
    const isTorn = kind !== "unproven";
    // The chosen one stands out.
    const radius = camera.px(tear === torn ? RADIUS + 4 : RADIUS);
    const arm = camera.px(CROSS);
    for (const [colour, width] of [[palette.css.free, 6], [palette.css.torn, 2.6]] as const) {
      stroke(brush, { colour, width, dash: isTorn ? [] : [5, 4] }, () => {
        context.arc(x, y, radius, 0, 2 * Math.PI);
        if (!isTorn) return;
        context.moveTo(x - arm, y - arm);
        context.lineTo(x + arm, y + arm);
        context.moveTo(x - arm, y + arm);
        context.lineTo(x + arm, y - arm);
      });
    }
  }
  writeWords(brush);
}

function writeWords(brush: Brush): void {
  const { context, camera, palette, tears, thing } = brush;
  const torn = thing?.kind === "torn" ? thing.tear : null;
  const weight = (tear: Tear): number => tear === torn ? Infinity : tear.off ?? 0;
  const written: (readonly [number, number, number])[] = [];
  for (const tear of [...tears].sort((a, b) => weight(b) - weight(a))) {
    const { place: [x, y], off } = tear;
    const text = `${t(called(tear))}${off === null ? "" : `: ${fixed(off, 1)} m`}`;
    label(brush, x, y, () => {
      context.font = "600 12px IBM Plex Mono, monospace";
      const width = context.measureText(text).width;
      const [middle, row] = camera.toScreen(x, y);
      // Near the right edge the label goes on the other side.
      const isCut = middle + BESIDE + width > camera.width;
      const from = isCut ? middle - BESIDE - width : middle + BESIDE;
      if (written.some(([begin, end, at]) => from < end && begin < from + width && Math.abs(row - at) < LINE)) return;
      written.push([from, from + width, row]);
      context.lineWidth = 3;
      context.setLineDash([]);
      context.strokeStyle = palette.css.free;
      context.fillStyle = palette.css.torn;
      context.textAlign = "left";
      context.strokeText(text, from - middle, 4);
      context.fillText(text, from - middle, 4);
    });
  }
}

/** The nearest mark within `reach` (m) of a map point. */
export function tearAt(tears: readonly Tear[], x: number, y: number, reach: number): Tear | null {
  const off = ({ place }: Tear): number => Math.hypot(place[0] - x, place[1] - y);
  const near = tears.filter((tear) => off(tear) <= reach);
  return near.sort((a, b) => off(a) - off(b))[0] ?? null;
}

/** Extent of a mark from its middle, CSS pixels. */
export const MARK = RADIUS + 3;
