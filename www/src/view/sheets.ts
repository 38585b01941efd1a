// Decides when each sheet of the map is redrawn. Slow sheets take turns: for one picture one of
// them is redrawn, the one that has waited longest; for the next, the quick ones. Waiting sheets
// are moved with the view meanwhile. Where the page has other long work to do for a picture, they
// wait for the next one.

import { takePicture } from "../long_work.js";
import type { Box, Camera } from "./camera.js";
import { type Draw, SHEETS, type SheetName, type Surface } from "./surface.js";

/** Sheets that take longer than this take turns, milliseconds. */
const LONG_MILLIS = 5;
/** Sheets that always take turns. */
const LONG: readonly SheetName[] = ["ground", "record"];

/** What a sheet has to show. */
export interface Wanted {
  /** Identifies the view; if it changes, the whole sheet is redrawn. */
  readonly view: string;
  /** Identifies the contents; a change may wait for this long, milliseconds. */
  readonly content?: string;
  readonly wait?: number;
  /** Where the contents differ from those drawn, asked when it is drawn; null: anywhere. */
  readonly within?: () => Box | null;
}

/** View and contents (empty if none), when it was drawn, and how long that took, milliseconds. */
interface Drawn { readonly view: string; readonly content: string; readonly at: number; readonly took: number }

const NOTHING: Drawn = { view: "", content: "", at: -Infinity, took: 0 };

export class Sheets {
  #drawn: Record<SheetName, Drawn> = { ground: NOTHING, record: NOTHING, overlays: NOTHING };
  /** A slow sheet was drawn for the last picture. */
  #wasLong = false;
  /** The last picture had other long work to do. */
  #isOwed = false;

  constructor(public surface: Surface) {}

  /** Draws on another surface from here on. */
  moveTo(surface: Surface, camera: Camera): void {
    this.surface.clear();
    this.surface = surface;
    this.resize(camera);
  }

  resize(camera: Camera): void {
    this.surface.resize(camera);
    this.forget();
  }

  /** Everything is redrawn at once. */
  forget(): void {
    this.#drawn = { ground: NOTHING, record: NOTHING, overlays: NOTHING };
  }

  /** Draws the sheets that are due with `drawOf`, and shows all. Returns those that were drawn. */
  draw(camera: Camera, now: number, wanted: Readonly<Record<SheetName, Wanted>>, drawOf: (sheet: SheetName) => Draw): readonly SheetName[] {
    const { surface } = this;
    if (surface.takeStale()) this.forget();
    const drawn = this.#drawn;
    const due = SHEETS.filter((name) => isDue(drawn[name], wanted[name], now));
    const isLong = (name: SheetName): boolean => LONG.includes(name) || drawn[name].took > LONG_MILLIS;
    const first = due.filter(isLong).sort((a, b) => drawn[a].at - drawn[b].at)[0];
    const isLongNext = first !== undefined && !(this.#wasLong && due.some((name) => !isLong(name)));
    const isLongNow = isLongNext && takePicture(now, this.#isOwed);
    this.#isOwed = isLongNext && !isLongNow;
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
