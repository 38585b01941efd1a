// Edits of the map, and the one being drawn, while the map is being edited.

import { EDIT, EDIT_STRIDE, type EditName } from "../../protocol/module.js";
import { addSegments, type Brush, type Pen, stroke } from "./layer.js";

/** In the order of the module. */
const KINDS = ["erase", "wall", "glass"] as const satisfies readonly EditName[];

export function draw(brush: Brush): void {
  const { context, scene: { edits }, edit } = brush;
  if (!edit) return;
  for (let i = 0; i + EDIT_STRIDE <= edits.length; i += EDIT_STRIDE) {
    const kind = KINDS[edits[i + EDIT.kind] ?? 0] ?? "erase";
    outlined(brush, kind, () => addSegments(context, edits.subarray(i + EDIT.x1, i + EDIT.y2 + 1)));
  }
  if (!edit.draft) return;
  const { kind, draft: { from, to } } = edit;
  if (kind === "erase") {
    const box = [Math.min(from[0], to[0]), Math.min(from[1], to[1]), Math.abs(to[0] - from[0]), Math.abs(to[1] - from[1])] as const;
    context.globalAlpha = 0.35;
    context.fillStyle = brush.palette.css.unknown;
    context.fillRect(...box);
    outlined(brush, kind, () => context.rect(...box));
  } else {
    outlined(brush, kind, () => addSegments(context, [...from, ...to]));
  }
}

/** With an outline, to be visible on walls too. */
function outlined(brush: Brush, kind: EditName, add: () => void): void {
  const { css } = brush.palette;
  const pens: Readonly<Record<EditName, Pen>> = {
    erase: { colour: css.torn, width: 2, dash: [6, 4] },
    wall: { colour: css.ink, width: 3.5 },
    glass: { colour: css.glass, width: 3.5, dash: [10, 3] },
  };
  stroke(brush, { colour: css.free, width: pens[kind].width + 3, alpha: 0.8 }, add);
  stroke(brush, pens[kind], add);
}
