// When each sheet of the map is drawn anew. What takes long takes turns: of that one sheet is drawn
// for a picture, the one that has waited longest, and the quick ones for the next. Those that wait
// are moved with the view meanwhile.

import type { Box, Camera } from "./camera.js";
import { type Draw, SHEETS, type SheetName, type Surface } from "./surface.js";

/** Sheets that take longer than this take turns, milliseconds. */
const LONG_MILLIS = 5;
/** Those that always do. */
const LONG: readonly SheetName[] = ["ground", "record"];

/** What a sheet shall show. */
export interface Wanted {
  /** Names the view; in another one all of the sheet is drawn anew. */
  readonly view: string;
  /** Names what is shown in it, and how long that may wait, milliseconds. */
  readonly content?: string;
  readonly wait?: number;
  /** Where that differs from what was drawn last, asked for when it is drawn; null: anywhere. */
  readonly within?: () => Box | null;
}

/** What it shows, empty while that is nothing, since when, and how long it took, milliseconds. */
interface Drawn { readonly view: string; readonly content: string; readonly at: number; readonly took: number }

const NOTHING: Drawn = { view: "", content: "", at: -Infinity, took: 0 };

export class Sheets {
  #drawn: Record<SheetName, Drawn> = { ground: NOTHING, record: NOTHING, overlays: NOTHING };
  /** For the last picture one that takes long was drawn. */
  #wasLong = false;

  constructor(public surface: Surface) {}

  /** From here on they are drawn on another surface. */
  moveTo(surface: Surface, camera: Camera): void {
    this.surface.clear();
    this.surface = surface;
    this.resize(camera);
  }

  resize(camera: Camera): void {
    this.surface.resize(camera);
    this.forget();
  }

  /** All is drawn anew, at once. */
  forget(): void {
    this.#drawn = { ground: NOTHING, record: NOTHING, overlays: NOTHING };
  }

  /** Draws what is due by `drawOf`, and shows all; returns what was drawn. */
  draw(camera: Camera, now: number, wanted: Readonly<Record<SheetName, Wanted>>, drawOf: (sheet: SheetName) => Draw): readonly SheetName[] {
    const { surface } = this;
    if (surface.takeStale()) this.forget();
    const drawn = this.#drawn;
    const due = SHEETS.filter((name) => isDue(drawn[name], wanted[name], now));
    const isLong = (name: SheetName): boolean => LONG.includes(name) || drawn[name].took > LONG_MILLIS;
    const first = due.filter(isLong).sort((a, b) => drawn[a].at - drawn[b].at)[0];
    const isLongNow = first !== undefined && !(this.#wasLong && due.some((name) => !isLong(name)));
    this.#wasLong = isLongNow;
    const drawnNow = due.filter((name) => (isLongNow ? name === first : !isLong(name)) || drawn[name].view === "");
    for (const name of drawnNow) {
      const { view, content = "", within } = wanted[name];
      const begin = performance.now();
      const changed = within?.() ?? null;
      surface.record(name, camera, view === drawn[name].view ? changed : null, drawOf(name));
      drawn[name] = { view, content, at: now, took: performance.now() - begin };
    }
    surface.show(camera);
    return drawnNow;
  }
}

function isDue(drawn: Drawn, { view, content = "", wait = 0 }: Wanted, now: number): boolean {
  return view !== drawn.view || (content !== drawn.content && now - drawn.at >= wait);
}
