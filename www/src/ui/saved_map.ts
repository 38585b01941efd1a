// The saved map that runs go on in: its picture, and where in it the robot begins.

import { css, nothing, type TemplateResult } from "lit";
import { degrees } from "../angle.js";
import type { MapStart } from "../protocol/module.js";
import type { SavedMap } from "../store.js";
import { Camera } from "../view/camera.js";
import { drawTiles } from "../view/canvas_bulk.js";
import { readPalette } from "../view/palette.js";
import { Tiles } from "../view/tiles.js";
import { html, t } from "../words.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";
import { filesOf, valueOf } from "./input.js";
import { picture, section } from "./style.js";

const FROM: Readonly<Record<MapStart["from"], string>> = {
  left: "where it was left",
  at: "at a place of the map",
  anywhere: "anywhere: it finds out where",
};

const MEANS: Readonly<Record<MapStart["from"], string>> = {
  left: "If what it sees is not what it saw there, it maps a piece of its own until its place is proved.",
  at: "Press on the picture where it stands, and drag the way it looks. Half a metre and 17° off will do; a wrong place spoils the map.",
  anywhere: "It maps a piece of its own until its place in the map is proved.",
};

/** The fields of a pose: label, and page units per unit of the module. */
const PLACE = [["x, m", 1], ["y, m", 1], ["heading, °", 180 / Math.PI]] as const;

/** A press that moves less than this keeps the heading, CSS pixels. */
const SLOP = 8;
/** Half the length of the arrow that shows the robot, CSS pixels. */
const ARROW = 10;

type Pose = readonly [number, number, number];

export class SlamSavedMap extends SlamElement {
  static override styles = [section, picture, css`
    label { display: grid; gap: 4px; font-size: 12.5px; color: var(--muted); margin-bottom: 8px; }
    label select { color: var(--ink); font-size: 14px; }
    canvas { background: var(--map-unknown); touch-action: none; cursor: crosshair; }
    .three { display: grid; grid-template-columns: 1fr 1fr 1fr; gap: 8px; }
    input[type="number"] { color: var(--ink); width: 100%; min-width: 0; }
    button { width: 100%; margin-bottom: 8px; }
    .changes { display: grid; grid-template-columns: repeat(auto-fit, minmax(90px, 1fr)); gap: 8px; margin-bottom: 8px; }
    .changes button, .changes .button { margin: 0; padding: 0 6px; }
    .changes label { display: contents; color: inherit; }
    .changes .button { color: var(--ink); font-size: 14px; }
  `];

  protected override readonly topics = ["run", "frame", "theme", "tab"] as const;
  readonly #camera = new Camera();
  readonly #tiles = new Tiles();
  #isPainted = false;
  /** A place is being asked for and has not been given yet. */
  #asks = false;
  /** The map in the tiles. */
  #shown: SavedMap["picture"] | null = null;
  /** The press that chooses a pose: where it began, CSS pixels, and the pose so far. */
  #press: { x: number; y: number; pose: Pose } | null = null;

  override connectedCallback(): void {
    super.connectedCallback();
    new ResizeObserver(() => this.#paint()).observe(this);
    for (const topic of ["run", "theme", "tab"] as const) this.store.on(topic, () => (this.#isPainted = false));
  }

  override render(): TemplateResult | typeof nothing {
    const { savedMap, status, method } = this.store;
    if (!savedMap && method !== "scan-matching") return nothing;
    if (!savedMap) {
      return html`
        <h2 id="saved-map">Saved map</h2>
        <p>A saved map of the same building (.slamlab) can be merged into the one that is drawn, and what newer parts of this one cover can be taken out.</p>
        ${this.#changes()}`;
    }
    const { name, start, picture, isBegun } = savedMap;
    const from = this.#asks ? "at" : start.from;
    const pose = start.from === "at" ? start.pose : picture.left;
    return html`
      <h2 id="saved-map">Saved map</h2>
      <p data-testid="going-on">Runs by scan matching go on in <b>${name}</b>${isBegun ? "" : " from the next one on"}.</p>
      ${status && isBegun ? html`<p class=${status.placed ? "" : "bad"} data-testid="placed">${!status.placed ? "Where the robot is in it is not proved yet." : start.from === "at" ? "The robot was told where it is in it." : "It is known where the robot is in it."}</p>` : nothing}
      <canvas data-testid="saved-map" role="img" aria-label="The saved map, with the robot where it begins" @pointerdown=${this.#down} @pointermove=${this.#move} @pointerup=${this.#up} @pointercancel=${this.#cancel}></canvas>
      <label>The robot begins
        <select data-testid="begin-at" @change=${(e: Event) => this.#choose(valueOf(e) as MapStart["from"])}>
          ${Object.entries(FROM).map(([name, words]) => html`<option value=${name} .selected=${name === from}>${words}</option>`)}
        </select></label>
      ${from === "at" ? html`<div class="three" role="group" aria-label="Where the robot begins in the saved map">
        ${PLACE.map(([words, unit], i) => html`<label>${words}<input type="number" inputmode="decimal" step="any" data-testid="begin-at-${i}"
          .value=${shown(pose, i, unit)} @change=${(e: Event) => this.#type(pose, i, unit, e.target as HTMLInputElement)}></label>`)}
      </div>` : nothing}
      <p>${MEANS[from]}</p>
      ${isBegun ? nothing : html`<button data-testid="begin-in-it" @click=${() => this.client.again("scan-matching")}>${icons.play} Begin in it</button>`}
      ${this.#changes()}
      <button data-testid="empty-map" @click=${() => this.client.send({ kind: "go-on", name: "", bytes: null })}>${icons.again} Begin with an empty map</button>`;
  }

  /** Actions on the map itself. */
  #changes(): TemplateResult {
    return html`<div class="changes">
      <label>
        <input type="file" accept=".slamlab" data-testid="merge-map" aria-label="Merge a saved map (.slamlab) into this one" @change=${(e: Event) => void this.client.files.mergeMap(filesOf(e))}>
        <span class="button" title="Join a saved map (.slamlab) to this one, if it is proved where it lies in it">${icons.open} Merge…</span>
      </label>
      <button data-testid="prune-map" title="Take out of this map what newer parts of it cover" @click=${() => this.client.send({ kind: "prune-map" })}>${icons.minus} Prune</button>
      ${this.store.savedMap ? html`<button data-testid="save-saved-map" title="Save the map as a file (.slamlab)" @click=${() => this.client.send({ kind: "save", what: "saved-map" })}>${icons.save} Save</button>` : nothing}
    </div>`;
  }

  override updated(): void {
    const picture = this.store.savedMap?.picture ?? null;
    if (picture !== this.#shown) {
      this.#shown = picture;
      this.#tiles.clear();
      if (picture?.grid) this.#tiles.take(picture.grid);
    }
    // A frame can change only the text.
    if (!this.#isPainted) this.#paint();
  }

  #choose(from: MapStart["from"]): void {
    // The place has not been given yet: until then the run goes on as it began.
    this.#asks = from === "at";
    if (from === "at") this.requestUpdate();
    else this.client.beginAt({ from });
  }

  #type(pose: Pose, index: number, unit: number, input: HTMLInputElement): void {
    const value = Number(input.value || NaN) / unit;
    const typed: [number, number, number] = [...pose];
    typed[index] = value;
    if (Number.isFinite(value)) this.#begin(typed);
    // The field shows its old value again.
    else input.value = shown(pose, index, unit);
  }

  #begin(pose: [number, number, number]): void {
    this.#asks = false;
    this.client.beginAt({ from: "at", pose });
  }

  /** Where the robot begins, if known; a choice that is being made comes first. */
  #pose(): Pose | null {
    const { savedMap } = this.store;
    if (this.#press) return this.#press.pose;
    if (!savedMap || savedMap.start.from === "anywhere") return null;
    return savedMap.start.from === "at" ? savedMap.start.pose : savedMap.picture.left;
  }

  #down = (event: PointerEvent): void => {
    if (event.button !== 0 || this.#tiles.size === 0) return;
    const { offsetX, offsetY } = event;
    const heading = this.#pose()?.[2] ?? 0;
    (event.target as HTMLElement).setPointerCapture(event.pointerId);
    this.#press = { x: offsetX, y: offsetY, pose: [...this.#camera.toMap(offsetX, offsetY), heading] };
    this.#paint();
  };

  #move = (event: PointerEvent): void => {
    if (!this.#press) return;
    const { x, y, pose } = this.#press;
    const [dx, dy] = [event.offsetX - x, event.offsetY - y];
    if (Math.hypot(dx, dy) >= SLOP) this.#press = { x, y, pose: [pose[0], pose[1], Math.atan2(-dy, dx)] };
    this.#paint();
  };

  #up = (): void => {
    const pose = this.#press?.pose;
    this.#press = null;
    if (pose) this.#begin([...pose]);
  };

  #cancel = (): void => {
    this.#press = null;
    this.#paint();
  };

  #paint(): void {
    const canvas = this.renderRoot.querySelector("canvas");
    const context = canvas?.getContext("2d");
    if (!canvas || !context || canvas.clientWidth === 0) return;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    const camera = Object.assign(this.#camera, { width: canvas.clientWidth, height: canvas.clientHeight, ratio });
    canvas.width = Math.round(canvas.clientWidth * ratio);
    canvas.height = Math.round(canvas.clientHeight * ratio);
    this.#isPainted = true;
    const box = this.#tiles.bounds();
    if (!box) return;
    Object.assign(camera, camera.fitted(box));
    const palette = readPalette();
    this.#tiles.colour(palette, "continuous");
    drawTiles(context, camera, this.#tiles, camera.visible);
    const pose = this.#pose();
    if (!pose) return;
    const [x, y] = camera.toScreen(pose[0], pose[1]);
    context.setTransform(ratio, 0, 0, ratio, x * ratio, y * ratio);
    context.rotate(-pose[2]);
    context.beginPath();
    context.moveTo(ARROW, 0);
    context.lineTo(-ARROW, 0.75 * ARROW);
    context.lineTo(-0.5 * ARROW, 0);
    context.lineTo(-ARROW, -0.75 * ARROW);
    context.closePath();
    context.lineWidth = 3;
    context.lineJoin = "round";
    context.strokeStyle = palette.css.free;
    context.fillStyle = palette.css.robot;
    context.stroke();
    context.fill();
    canvas.title = t`x ${pose[0].toFixed(1)}, y ${pose[1].toFixed(1)} m, heading ${Math.round(degrees(pose[2]))}°`;
  }
}

/** A number of a pose as its field shows it. */
function shown(pose: Pose, index: number, unit: number): string {
  return String(Number(((pose[index] ?? 0) * unit).toFixed(unit === 1 ? 2 : 1)));
}

customElements.define("slam-saved-map", SlamSavedMap);
