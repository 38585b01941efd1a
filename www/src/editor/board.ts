// The drawing canvas: translates pointer, wheel, touch and keys into actions of the model.

import { css, LitElement, type TemplateResult } from "lit";
import { shared } from "../ui/style.js";
import { Camera } from "../view/camera.js";
import { listenToGestures } from "../view/gestures.js";
import { html } from "../words.js";
import { boxOf } from "./outline.js";
import type { Point } from "./drawing.js";
import type { EditorModel } from "./model.js";
import { coloursOf, type Colours, paint } from "./paint.js";
import { gridOf, onGrid } from "./snap.js";
import { made, measure } from "./tools.js";

const ARROWS: Readonly<Record<string, Point>> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
/** How far an arrow key moves with Shift, cells. */
const FAR = 10;

export class EditorBoard extends LitElement {
  static override styles = [shared, css`
    :host { position: relative; overflow: hidden; border: 1px solid var(--line); border-radius: 12px; background: var(--sunk); min-height: 0; }
    canvas { position: absolute; inset: 0; width: 100%; height: 100%; touch-action: none; cursor: crosshair; border-radius: 11px; }
    canvas:focus-visible { outline-offset: -3px; }
    p { position: absolute; left: 12px; bottom: 10px; margin: 0; padding: 4px 9px; border-radius: 8px; background: var(--glass); font-size: 12.5px; pointer-events: none; max-width: calc(100% - 24px); }
  `];

  /** Set by the creator of the element. */
  model!: EditorModel;
  readonly camera = new Camera();
  #colours: Colours | null = null;
  /** The view shows the whole drawing until somebody moves it. */
  #isWhole = true;
  #last: Point | null = null;
  readonly #resized = new ResizeObserver(() => this.#resize());

  override firstUpdated(): void {
    const canvas = this.canvas;
    const at = (x: number, y: number): Point => this.camera.toMap(x, y);
    // Alt switches snapping off: the point stays exactly where it is.
    for (const kind of ["pointerdown", "pointermove", "pointerup"] as const) canvas.addEventListener(kind, (event) => (this.model.isHeldOff = event.altKey), { capture: true });
    listenToGestures(canvas, {
      pan: (dx, dy) => this.#look(() => this.camera.panBy(dx, dy)),
      zoom: (factor, x, y) => this.#look(() => this.camera.zoomAt(factor, x, y)),
      tap: (x, y) => this.model.tap(at(x, y), this.camera.scale),
      hover: (x, y) => this.model.hover(at(x, y), this.camera.scale),
      leave: () => this.model.leave(),
      draws: () => {
        this.#last = null;
        return true;
      },
      draw: (from, to) => {
        // A drag that starts on empty ground moves the view.
        const before = this.#last ?? from;
        this.#last = to;
        const isView = this.model.drag(this.#from ?? (this.#from = at(...from)), at(...to), this.camera.scale);
        if (isView) this.#look(() => this.camera.panBy(to[0] - before[0], to[1] - before[1]));
      },
      drawn: (isDone) => {
        this.#from = null;
        this.model.drop(isDone, this.camera.scale);
      },
    });
    canvas.addEventListener("keydown", (event) => this.#key(event));
    this.#resized.observe(this);
    this.model.on(() => this.draw());
  }

  /** Where the press began, m: the view may move meanwhile. */
  #from: Point | null = null;

  get canvas(): HTMLCanvasElement {
    return this.renderRoot.querySelector("canvas") as HTMLCanvasElement;
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.#isWhole = true;
  }

  #look(change: () => void): void {
    this.#isWhole = false;
    change();
    this.draw();
  }

  zoom(factor: number): void {
    const { width, height } = this.camera;
    this.#look(() => this.camera.zoomAt(factor, width / 2, height / 2));
  }

  /** Shows the whole drawing. */
  fit(): void {
    this.#isWhole = true;
    const { minX, minY, maxX, maxY } = boxOf(this.model.drawing);
    const margin = 0.06 * Math.max(maxX - minX, maxY - minY);
    Object.assign(this.camera, this.camera.fitted({ minX: minX - margin, minY: minY - margin, maxX: maxX + margin, maxY: maxY + margin }, 120));
    this.draw();
  }

  /** Reads the colours of the theme again. */
  recolour(): void {
    this.#colours = null;
    this.draw();
  }

  #resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    const ratio = Math.min(devicePixelRatio, 2);
    Object.assign(this.camera, { width, height, ratio });
    Object.assign(this.canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
    if (this.#isWhole) this.fit();
    else this.draw();
  }

  draw(): void {
    const context = this.canvas?.getContext("2d");
    if (!context || this.camera.width <= 1) return;
    this.#colours ??= coloursOf(this);
    const { model } = this;
    const { draft, cursor } = model;
    const coming = draft && cursor ? { ...draft, points: [...draft.points, cursor.point] } : draft;
    paint(context, this.camera, this.#colours, {
      drawing: model.drawing, chosen: model.chosen, wrong: model.wrong, handles: model.handles(this.camera.scale),
      draft: coming && made(coming, model.material, false), points: draft?.points ?? [], cursor,
      measure: draft && cursor ? measure(draft, cursor.point) : "",
    });
    this.requestUpdate();
  }

  #key(event: KeyboardEvent): void {
    const { model, camera: { scale } } = this;
    if (event.ctrlKey || event.metaKey) return;
    const arrow = ARROWS[event.key];
    const grid = gridOf(scale);
    if (arrow) {
      const far = grid * (event.shiftKey ? FAR : 1);
      const by: Point = [arrow[0] * far, arrow[1] * far];
      if (model.tool === "select") model.move(by, "arrows");
      else this.#point(by);
    } else if (event.key === "Enter" && model.tool !== "select") {
      const at = model.cursor?.point;
      if (!at) this.#point([0, 0]);
      else if (event.shiftKey) model.finish(false);
      else model.set(at, grid / 2);
    } else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** Moves the place of the next point by the keys. */
  #point(by: Point): void {
    const { model, camera } = this;
    const grid = gridOf(camera.scale);
    const [x, y] = model.cursor?.point ?? model.draft?.points.at(-1) ?? [camera.x, camera.y];
    const point: Point = [onGrid(x + by[0], grid), onGrid(y + by[1], grid)];
    model.cursor = { point, to: "grid" };
    const [screenX, screenY] = camera.toScreen(...point);
    if (screenX < 20 || screenY < 20 || screenX > camera.width - 20 || screenY > camera.height - 20) Object.assign(camera, { x: point[0], y: point[1] });
    model.notify();
  }

  override render(): TemplateResult {
    const { cursor, draft } = this.model;
    const words = cursor ? `${cursor.point[0].toFixed(2)}, ${cursor.point[1].toFixed(2)} m` : "";
    const size = draft && cursor ? measure(draft, cursor.point) : "";
    return html`
      <canvas tabindex="0" role="application" data-testid="editor-board" aria-label="Drawing board. Arrows move the cross or the chosen part, Enter sets a point, Escape ends."></canvas>
      <p class="num" data-testid="editor-measure" aria-live="polite" ?hidden=${words === ""}>${words}${size ? ` · ${size}` : ""}</p>
    `;
  }
}

customElements.define("editor-board", EditorBoard);
