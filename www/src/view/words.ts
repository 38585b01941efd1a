// What is under the pointer, in words.

import { fixed } from "../ui/format.js";
import { tearWords } from "../ui/tears.js";
import { t } from "../words.js";
import { hitAt, isDoorOpen, type Reading, type Sight, type Target, type Thing } from "./things.js";
import type { GridView, Tiles } from "./tiles.js";

/** A place, m, what the grid says of it, and what a click there acts on. `tiles`: the grid, or the
    field of it that is shown. */
export function placeWords(sight: Sight, tiles: Tiles, { mark, wall, door, room }: Target, x: number, y: number): string {
  const { store, scene } = sight;
  const p = scene.tiles.probabilityAt(x, y);
  const what = p === null ? t("unknown") : p >= 0.5 ? t`${Math.round(p * 100)} % obstacle` : t`${Math.round((1 - p) * 100)} % free`;
  const reading = hitAt(sight, x, y);
  const value = tiles === scene.tiles ? 0 : tiles.byteAt(x, y);
  const more = [
    value === 0 ? "" : ` · ${fieldWords(store.gridView, value, scene.field.step)}`,
    wall === null ? "" : ` · ${t`wall ${wall}`}`,
    door === null || store.inspecting ? "" : ` · ${isDoorOpen(scene, door) ? t`door ${door + 1}, click to shut it` : t`door ${door + 1}, click to open it`}`,
    room === null ? "" : ` · ${t`region ${store.roomNumbers[room]}`}`,
    mark === null ? "" : ` · ${markWords(mark)}`,
    reading === null ? "" : ` · ${readingWords(reading)}`,
  ];
  return `x ${metres(x)}  y ${metres(y)} m · ${what}${more.join("")}`;
}

/** The meaning of a byte of a field. */
function fieldWords(view: GridView, byte: number, step: number): string {
  const [value, more] = [(byte - 1) * step, byte === 255 ? "≥ " : ""];
  if (view === "likelihood") return t`likelihood ${fixed(value, 2)}`;
  if (view === "room") return byte === 1 ? t("the robot may not be here") : t`the robot's middle has ${more}${fixed(value, 2)} m of room`;
  return t`${more}${fixed(value, 2)} m to the nearest wall`;
}

/** A hit as measured: the range with its σ, and the strength of the echo, if the sensor reports
    it. */
function readingWords({ range, sigma, quality }: Reading): string {
  const strength = Number.isNaN(quality) ? "" : t`, quality ${quality}`;
  return t`beam ${fixed(range, 2)} ± ${fixed(sigma, 2)} m${strength}`;
}

function metres(value: number): string {
  return (value < 0 ? "−" : "") + fixed(Math.abs(value), 2);
}

/** A mark of the map. */
function markWords(mark: Thing): string {
  if (mark.kind === "closure") return t`closure ${mark.name[0]}–${mark.name[1]}`;
  if (mark.kind === "join") return t`join ${mark.submap - 1}–${mark.submap}`;
  return mark.kind === "torn" ? t`${tearWords(mark.tear)}, click to see more` : "";
}
