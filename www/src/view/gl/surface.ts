// The map on one WebGL2 canvas. A graphics card can be taken away at any time, and given back: who
// draws is told both, and draws on canvases in between.

import type { Box, Camera } from "../camera.js";
import { SHEETS, type SheetName } from "../parts.js";
import type { Draw, Surface } from "../surface.js";
import { List } from "./list.js";
import { type Recorded, GlRenderer } from "./renderer.js";

export interface Hearer {
  /** There is a graphics card to draw with. */
  came(surface: Surface): void;
  /** There is none, or no more; why. */
  went(why: string): void;
}

/** Tells whether the canvas can be drawn on with WebGL2, and whenever that changes. */
export function watchGl(canvas: HTMLCanvasElement, hearer: Hearer): void {
  const begin = (): void => {
    const gl = canvas.getContext("webgl2", { alpha: true, antialias: false, depth: true, stencil: true });
    if (!gl) return hearer.went("this browser gives no WebGL2");
    if (gl.isContextLost()) return;
    const renderer = new GlRenderer(gl);
    const { fault } = renderer;
    if (fault === null) hearer.came(new GlSurface(canvas, renderer));
    else if (!gl.isContextLost()) hearer.went(`its graphics card does not take the programs (${fault})`);
  };
  canvas.addEventListener("webglcontextlost", (event) => {
    // Or it would not be given back.
    event.preventDefault();
    hearer.went("the graphics card was taken away");
  });
  canvas.addEventListener("webglcontextrestored", begin);
  begin();
}

class GlSurface implements Surface {
  readonly kind = "webgl2";
  readonly #sheets = Object.fromEntries(SHEETS.map((name) => [name, { list: new List(), matrix: null }])) as unknown as Record<SheetName, Recorded>;
  #shown = "";
  #generation = 0;

  constructor(readonly canvas: HTMLCanvasElement, readonly renderer: GlRenderer) {
    // Texts that were drawn before their font had come are drawn again.
    document.fonts.addEventListener("loadingdone", () => renderer.atlas.clear());
  }

  resize({ width, height, ratio }: Camera): void {
    Object.assign(this.canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
    for (const sheet of Object.values(this.#sheets)) sheet.matrix = null;
    this.#shown = "";
  }

  record(name: SheetName, camera: Camera, _within: Box | null, draw: Draw): void {
    const pencil = this.renderer.record(this.#sheets[name], camera);
    draw(pencil, pencil);
    this.#shown = "";
  }

  show(camera: Camera): void {
    const shown = camera.transform.join();
    if (shown === this.#shown && !this.renderer.isBehind) return;
    this.#shown = shown;
    this.renderer.draw(SHEETS.map((name) => this.#sheets[name]), camera);
  }

  takeStale(): boolean {
    const { generation } = this.renderer;
    const isStale = generation !== this.#generation;
    this.#generation = generation;
    return isStale;
  }

  clear(): void {
    this.canvas.width = this.canvas.height = 1;
  }

  copyTo(context: OffscreenCanvasRenderingContext2D, camera: Camera): void {
    // What was drawn for the screen is gone by now.
    this.#shown = "";
    this.show(camera);
    context.drawImage(this.canvas, 0, 0);
  }
}
