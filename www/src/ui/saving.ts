// What can be saved of the run, in one dialog: one file if one is ticked, a ZIP archive if there
// are several. All files are collected when the dialog opens, so the list shows the size of each,
// or why there is none, and what is saved is what was listed.
//
// A bundle of its own, because a first visit does not need it.

import { css, nothing, type TemplateResult } from "lit";
import type { Collected } from "../client.js";
import type { SavedFile, SavedKind } from "../protocol/module.js";
import { download, fileName } from "../save.js";
import { html, t } from "../words.js";
import { packed } from "../zip.js";
import { dialog, SlamDialog } from "./dialog.js";
import { icons } from "./icons.js";

/** Files made by the page itself; the module makes the others. */
export type PageKind = "png" | "svg" | "csv" | "link";
export type Kind = SavedKind | PageKind;
type Preset = "ros" | "sheet";

interface Offered {
  /** Name and format. */
  readonly title: string;
  /** What it can be used for. */
  readonly about: string;
  readonly preset?: Preset;
}

const OFFERED: Readonly<Record<Kind, Offered>> = {
  map: { title: "Map for ROS (PGM, YAML)", about: "Free, occupied and unknown cells, as map_server loads them.", preset: "ros" },
  "map-scale": { title: "Map for ROS, probabilities (PNG, YAML)", about: "The same with grey tones in between, for the mode “scale”." },
  "map-raw": { title: "Map for ROS, raw percentages (PGM, YAML)", about: "Each byte is the probability in per cent, for the mode “raw”." },
  "og-map": { title: "Map as text (OGmap.txt)", about: "A number for each cell, to be read by a script." },
  plan: { title: "Walls (SVG, DXF, GeoJSON)", about: "The floor plan with lengths, for drawing programs, CAD and maps." },
  rooms: { title: "Rooms and doors (GeoJSON)", about: "Outlines of rooms with areas, and doors with widths." },
  tum: { title: "Way of the robot (TUM)", about: "A pose for each scan, as evo and other tools compare them.", preset: "ros" },
  csv: { title: "Curves over time (CSV)", about: "What the plots show, with units: a table for each tab.", preset: "sheet" },
  carmen: { title: "Scans and odometry (CARMEN log)", about: "What the sensors said, to be mapped again by any method.", preset: "ros" },
  revolutions: { title: "Scans alone, a revolution a line (.txt)", about: "For programs that have no use for wheels." },
  slamlab: { title: "Map to go on in later (.slamlab)", about: "The whole map with its submaps: drop it here, and the robot goes on." },
  smap: { title: "Points, way and walls (.smap)", about: "The map as a list of points, to be driven in or found in." },
  g2o: { title: "Pose graph (.g2o)", about: "Poses and constraints, for other solvers." },
  png: { title: "Map as a picture (PNG)", about: "A pixel for each cell, in the colours of the page." },
  svg: { title: "What is seen (SVG)", about: "All layers that are on, sharp at any size." },
  link: { title: "Link of the experiment (.url)", about: "It does this run again, to the bit, with all that was done: open it, or drop it here." },
};
/** Why the page can make none of its own files. */
const NOTHING_YET = "there is nothing to see yet: let the robot scan first";
const NONE: Readonly<Record<PageKind, string>> = {
  png: NOTHING_YET, svg: NOTHING_YET, csv: NOTHING_YET,
  link: "only a simulation has a link, and only while nothing was done in it that a link cannot tell",
};
const isOfPage = (kind: Kind): kind is PageKind => kind in NONE;
const KINDS = Object.keys(OFFERED) as Kind[];

export class SlamSaving extends SlamDialog {
  static override styles = [dialog, css`
    ul { margin: 0 0 14px; padding: 0; list-style: none; border: 1px solid var(--line); border-radius: 12px; }
    li + li { border-top: 1px solid var(--line); }
    label { display: grid; grid-template-columns: 20px minmax(0, 1fr) auto; align-items: start; gap: 2px 10px; padding: 9px 14px; cursor: pointer; }
    label:has(:disabled) { cursor: default; }
    label:has(:disabled) b { color: var(--muted); }
    input { grid-row: span 2; width: 18px; height: 18px; margin: 1px 0 0; accent-color: var(--accent); }
    b { font-weight: 570; }
    small { grid-column: 2 / -1; font-size: 12.5px; line-height: 1.4; color: var(--muted); }
    .size { font-size: 12.5px; color: var(--muted); }
    .presets { display: flex; flex-wrap: wrap; gap: 8px; margin-bottom: 12px; }
    footer { position: sticky; bottom: -30px; display: flex; flex-wrap: wrap; align-items: center; justify-content: space-between; gap: 10px; margin: 0 -30px -30px; padding: 14px 30px; background: var(--surface); border-top: 1px solid var(--line); }
    .save { color: var(--on-accent); background: var(--accent); border-color: transparent; }
    .save:hover { background: var(--accent); filter: brightness(1.06); }
    @media (max-width: 760px) { footer { bottom: -18px; margin: 0 -18px -18px; padding: 12px 18px; } }
  `];

  /** Makes a file of the page; none while there is nothing to see. Set by main.ts. */
  make!: (kind: PageKind) => Promise<readonly SavedFile[]>;

  readonly #collected = new Map<Kind, Collected>();
  readonly #ticked = new Set<Kind>(["map"]);
  #collecting = 0;
  #title = "";
  #isPacking = false;

  override show(): void {
    this.#collected.clear();
    this.#title = this.store.title;
    this.requestUpdate();
    super.show();
    void this.#collect();
  }

  override render(): TemplateResult {
    const chosen = this.#files();
    const size = chosen.reduce((sum, { bytes }) => sum + bytes.length, 0);
    return html`<dialog aria-labelledby="title" data-testid="saving" @click=${(e: Event) => e.target === e.currentTarget && this.close()}>
      <header><h3 id="title">Save</h3><button class="icon" aria-label="Close" data-testid="saving-close" @click=${() => this.close()}>${icons.close}</button></header>
      <p>One file is saved as it is, several in one ZIP archive. Drop the archive on this page to open what is in it.</p>
      <div class="presets" role="group" aria-label="What to tick">
        <button data-testid="saving-all" @click=${() => this.#tick(KINDS)}>Everything</button>
        <button data-testid="saving-ros" @click=${() => this.#tick(of("ros"))}>For ROS</button>
        <button data-testid="saving-sheet" @click=${() => this.#tick(of("sheet"))}>For a spreadsheet</button>
        <button data-testid="saving-none" @click=${() => this.#tick([])}>Nothing</button>
      </div>
      <ul>${KINDS.map((kind) => this.#row(kind))}</ul>
      <footer>
        <span class="num" data-testid="saving-sum" role="status">${chosen.length === 0 ? html`Nothing is ticked that can be saved` : chosen.length === 1 ? html`1 file, ${sizeOf(size)}` : html`${chosen.length} files, ${sizeOf(size)}`}</span>
        <button class="save" data-testid="saving-save" ?disabled=${chosen.length === 0 || this.#isWaiting() || this.#isPacking} @click=${() => void this.#save()}>${icons.save} Save</button>
      </footer>
    </dialog>`;
  }

  #row(kind: Kind): TemplateResult {
    const { title, about } = OFFERED[kind];
    const collected = this.#collected.get(kind);
    const isMissing = collected?.files.length === 0;
    return html`<li><label>
      <input type="checkbox" data-testid="saving-${kind}" .checked=${this.#ticked.has(kind) && !isMissing} ?disabled=${isMissing} @change=${() => this.#toggle(kind)}>
      <b>${t(title)}</b><span class="size num">${collected ? isMissing ? nothing : sizeOf(collected.files.reduce((sum, { bytes }) => sum + bytes.length, 0)) : "…"}</span>
      <small data-testid="saving-about-${kind}">${isMissing ? html`Not now: ${collected.error}` : t(about)}</small>
    </label></li>`;
  }

  /** Collects one after the other, so that the run goes on between them. */
  async #collect(): Promise<void> {
    this.#collecting += 1;
    const mine = this.#collecting;
    for (const kind of KINDS) {
      const collected = await this.#one(kind);
      if (mine !== this.#collecting || !this.shown) return;
      this.#collected.set(kind, collected);
      this.requestUpdate();
    }
  }

  async #one(kind: Kind): Promise<Collected> {
    if (!isOfPage(kind)) return this.client.collect(kind);
    const files = await this.make(kind);
    return { files, error: files.length === 0 ? t(NONE[kind]) : "" };
  }

  #tick(kinds: readonly Kind[]): void {
    this.#ticked.clear();
    for (const kind of kinds) this.#ticked.add(kind);
    this.requestUpdate();
  }

  #toggle(kind: Kind): void {
    if (!this.#ticked.delete(kind)) this.#ticked.add(kind);
    this.requestUpdate();
  }

  /** Whether something that is ticked has not arrived yet. */
  #isWaiting(): boolean {
    return [...this.#ticked].some((kind) => !this.#collected.has(kind));
  }

  #files(): SavedFile[] {
    return KINDS.filter((kind) => this.#ticked.has(kind)).flatMap((kind) => this.#collected.get(kind)?.files ?? []);
  }

  async #save(): Promise<void> {
    const files = this.#files();
    const [first, ...more] = files;
    if (!first) return;
    this.#isPacking = true;
    this.requestUpdate();
    const name = more.length === 0 ? first.name : `${fileName(this.#title)}.zip`;
    try {
      download(more.length === 0 ? new Blob([first.bytes], { type: first.mime }) : await packed(files), name);
    } finally {
      this.#isPacking = false;
    }
    this.close();
    this.client.tellSaved([name]);
  }
}

const of = (preset: Preset): Kind[] => KINDS.filter((kind) => OFFERED[kind].preset === preset);

function sizeOf(bytes: number): string {
  return bytes < 1e3 ? `${bytes} B` : bytes < 1e6 ? `${(bytes / 1e3).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
}

customElements.define("slam-saving", SlamSaving);
