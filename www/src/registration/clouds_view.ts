// The two clouds, large: the moving one can be dragged and turned by mouse, touch or keys, and
// either can be drawn by hand.

import { css, type TemplateResult } from "lit";
import { isTouched } from "../screen.js";
import { type Box, Camera, union } from "../view/camera.js";
import { html, t } from "../words.js";
import { boxOf, coloursOf, drawCloud, drawOrigin, drawRules, prepare } from "./draw.js";
import { LabElement } from "./element.js";
import { middle, place, takeBack, turned, wrap } from "./pose.js";
import type { Pose } from "./protocol.js";

/** Step of one key press, and with Shift: m and rad. */
const STEP = { shift: [0.05, 0.25], turn: [Math.PI / 90, Math.PI / 12] } as const;
/** Turn by one notch of the wheel, rad. */
const NOTCH = Math.PI / 60;
/** Distance between points of a drawn stroke, m. */
const SPACING = 0.05;
/** The view of an empty drawing, m. */
const SHEET: Box = { minX: -4, minY: -2.5, maxX: 4, maxY: 2.5 };
/** Distance of the handle from the cloud's middle, and how near a press has to be, pixels. */
const ARM = 74;
const REACH = 24;

export class LabClouds extends LabElement {
  static override styles = css`
    :host { position: relative; overflow: hidden; border: 1px solid var(--line); border-radius: 14px; background: var(--map-free); }
    canvas { position: absolute; inset: 0; width: 100%; height: 100%; touch-action: none; cursor: grab; border-radius: 14px; outline-offset: -3px; }
    canvas.drags { cursor: grabbing; }
    canvas.pen { cursor: crosshair; }
    .key { position: absolute; left: 12px; top: 10px; display: flex; gap: 6px 14px; flex-wrap: wrap; font-size: 12.5px; pointer-events: none; padding: 4px 9px; border-radius: 8px; background: var(--glass); max-width: calc(100% - 24px); }
    .key span { display: flex; align-items: center; gap: 6px; }
    i { width: 9px; height: 9px; border-radius: 50%; flex: none; }
    .fixed { background: var(--map-truth); }
    .moving { background: var(--map-estimate); }
    .hint { position: absolute; left: 12px; bottom: 10px; right: 12px; font-size: 12px; color: var(--muted); pointer-events: none; }
    .hint span { padding: 2px 8px; border-radius: 6px; background: var(--glass); }
  `;

  readonly #camera = new Camera();
  #box: Box = SHEET;
  readonly #pointers = new Map<number, { x: number; y: number }>();
  #what: "move" | "turn" | "draw" | null = null;
  #last: [number, number] | null = null;
  /** The clouds that the view was fitted to: it stays the same while they are dragged. */
  #fitted: Float64Array | null = null;

  override render(): TemplateResult {
    const { pen, clouds } = this.model;
    const touch = isTouched();
    const isLacking = clouds.fixed.length === 0 || clouds.moving.length === 0;
    const hint = pen ? t`Draw the ${pen} cloud with ${touch ? "a finger" : "the pen"}: points come every ${100 * SPACING} cm.`
      : isLacking ? "Two clouds are needed." : touch ? "Drag the orange cloud; its handle or two fingers turn it." : "Drag the orange cloud; its handle or the wheel turns it. Keys: arrows, Q and E; Shift for more; Home takes it back.";
    return html`
      <canvas tabindex="0" role="application" data-testid="lab-clouds" class=${pen ? "pen" : this.#what ? "drags" : ""}
        aria-label="Two clouds of points. Arrow keys move the moving one, Q and E turn it, with Shift by more, Home takes it to where it lay."
        @pointerdown=${this.#down} @pointermove=${this.#move} @pointerup=${this.#up} @pointercancel=${this.#up} @wheel=${this.#wheel} @keydown=${this.#key}></canvas>
      <div class="key" aria-hidden="true"><span><i class="fixed"></i>fixed, ${clouds.fixed.length / 2} points</span><span><i class="moving"></i>moving, ${clouds.moving.length / 2} points</span></div>
      <div class="hint" aria-hidden="true"><span>${hint}</span></div>`;
  }

  override updated(): void {
    const canvas = this.#canvas;
    const { clouds, start } = this.model;
    if (this.#fitted !== clouds.fixed && this.#what === null) {
      this.#fitted = clouds.fixed;
      this.#box = this.#boxNow() ?? SHEET;
    }
    if (this.model.pen) this.#box = union(this.#boxNow(), SHEET);
    // Room for the text above and below.
    Object.assign(this.#camera, { inset: { top: 44, bottom: 34, left: 12, right: 12 } });
    const brush = prepare(canvas, this.#box, coloursOf(this), this.#camera);
    if (!brush) return;
    drawRules(brush);
    drawCloud(brush, clouds.fixed, [0, 0, 0], brush.colours.fixed, 2.1);
    drawCloud(brush, clouds.moving, start, brush.colours.moving, 2.1);
    if (clouds.areScans) drawOrigin(brush, start, brush.colours.moving);
    if (clouds.moving.length > 0 && !this.model.pen) this.#drawHandle(brush.context, brush.colours.moving);
  }

  get #canvas(): HTMLCanvasElement {
    return this.renderRoot.querySelector("canvas") as HTMLCanvasElement;
  }

  #boxNow(): Box | null {
    const { clouds, start } = this.model;
    const [fixed, moving] = [boxOf(clouds.fixed, [0, 0, 0], clouds.areScans), boxOf(clouds.moving, start, clouds.areScans)];
    return moving ? union(fixed, moving) : fixed;
  }

  /** The middle of the moving cloud and its handle, CSS pixels. */
  get #handle(): { from: [number, number]; to: [number, number] } {
    const { clouds, start } = this.model;
    const from = this.#camera.toScreen(...place(start, ...middle(clouds.moving)));
    return { from, to: [from[0] + ARM * Math.cos(start[2]), from[1] - ARM * Math.sin(start[2])] };
  }

  #drawHandle(context: CanvasRenderingContext2D, colour: string): void {
    const { from, to } = this.#handle;
    context.strokeStyle = context.fillStyle = colour;
    context.lineWidth = 2;
    context.setLineDash([4, 4]);
    context.beginPath();
    context.moveTo(...from);
    context.lineTo(...to);
    context.stroke();
    context.setLineDash([]);
    context.beginPath();
    context.arc(...to, 8, 0, 2 * Math.PI);
    context.fill();
    context.beginPath();
    context.arc(...from, 3, 0, 2 * Math.PI);
    context.fill();
  }

  #at(event: MouseEvent): { x: number; y: number } {
    const box = this.#canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  readonly #down = (event: PointerEvent): void => {
    if (event.button !== 0) return;
    const now = this.#at(event);
    this.#canvas.setPointerCapture(event.pointerId);
    this.#pointers.set(event.pointerId, now);
    const { pen } = this.model;
    const { to } = this.#handle;
    this.#what = pen ? "draw" : Math.hypot(now.x - to[0], now.y - to[1]) < REACH ? "turn" : "move";
    this.#last = null;
    if (pen) this.#drawTo(now);
    this.requestUpdate();
  };

  readonly #move = (event: PointerEvent): void => {
    const before = this.#pointers.get(event.pointerId);
    if (!before) return;
    const now = this.#at(event);
    this.#pointers.set(event.pointerId, now);
    const { model } = this;
    const other = [...this.#pointers].find(([id]) => id !== event.pointerId)?.[1];
    if (this.#what === "draw") return this.#drawTo(now);
    if (other) {
      // Two fingers move the cloud: it turns about the resting one.
      const angle = (p: { x: number; y: number }): number => Math.atan2(-(p.y - other.y), p.x - other.x);
      const pivot = this.#camera.toMap(other.x, other.y);
      return model.move(turned(model.start, wrap(angle(now) - angle(before)), pivot));
    }
    if (this.#what === "turn") {
      const { from } = this.#handle;
      const heading = Math.atan2(-(now.y - from[1]), now.x - from[0]);
      return model.turn(wrap(heading - model.start[2]));
    }
    const [x, y, heading] = model.start;
    const { scale } = this.#camera;
    model.move([x + (now.x - before.x) / scale, y - (now.y - before.y) / scale, heading]);
  };

  readonly #up = (event: PointerEvent): void => {
    this.#pointers.delete(event.pointerId);
    if (this.#pointers.size > 0) return;
    this.#what = null;
    this.requestUpdate();
  };

  readonly #wheel = (event: WheelEvent): void => {
    event.preventDefault();
    if (this.model.pen) return;
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 1 : event.deltaY === 0 ? 0 : Math.min(Math.abs(event.deltaY) / 100, 1);
    this.model.turn(-Math.sign(event.deltaY) * lines * NOTCH);
  };

  readonly #key = (event: KeyboardEvent): void => {
    if (event.ctrlKey || event.metaKey || event.altKey || this.model.pen) return;
    const [x, y, heading] = this.model.start;
    const [shift, turn] = [STEP.shift[event.shiftKey ? 1 : 0], STEP.turn[event.shiftKey ? 1 : 0]];
    const moves: Readonly<Record<string, () => void>> = {
      ArrowRight: () => this.model.move([x + shift, y, heading]),
      ArrowLeft: () => this.model.move([x - shift, y, heading]),
      ArrowUp: () => this.model.move([x, y + shift, heading]),
      ArrowDown: () => this.model.move([x, y - shift, heading]),
      KeyQ: () => this.model.turn(turn),
      KeyE: () => this.model.turn(-turn),
      Home: () => this.model.move([0, 0, 0]),
    };
    const move = moves[event.code];
    if (!move) return;
    event.preventDefault();
    move();
  };

  /** Adds points from the last one to here. */
  #drawTo({ x, y }: { x: number; y: number }): void {
    const { clouds, pen, start } = this.model;
    if (!pen) return;
    const own: Pose = pen === "moving" ? start : [0, 0, 0];
    const to = takeBack(own, ...this.#camera.toMap(x, y));
    const from = this.#last ?? to;
    const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
    const count = this.#last ? Math.floor(length / SPACING) : 1;
    if (count === 0) return;
    const more: number[] = [];
    for (let i = 1; i <= count; i += 1) {
      const part = this.#last ? (i * SPACING) / length : 1;
      more.push(from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1]));
    }
    this.#last = [more.at(-2) ?? to[0], more.at(-1) ?? to[1]];
    const points = new Float64Array([...clouds[pen], ...more]);
    this.model.setClouds({ ...clouds, [pen]: points }, start);
  }
}

customElements.define("lab-clouds", LabClouds);
