// The map on one WebGL2 canvas. A bundle of its own, loaded if there is a suitable graphics card
// (`graphics.ts`).

import type { Box, Camera } from "../camera.js";
import { type Draw, SHEETS, type SheetName, type Surface } from "../surface.js";
import { List } from "./list.js";
import { type Recorded, GlRenderer } from "./renderer.js";

/** The surface on a context; null if that has been lost meanwhile. Throws if the graphics card
    rejects the programs. */
export function surfaceOn(canvas: HTMLCanvasElement, gl: WebGL2RenderingContext): Surface | null {
  if (gl.isContextLost()) return null;
  const renderer = new GlRenderer(gl);
  const { fault } = renderer;
  if (gl.isContextLost()) return null;
  if (fault !== null) throw new Error(fault);
  return new GlSurface(canvas, renderer);
}

/** Grows when fonts have been loaded: texts drawn before are drawn again. */
let fonts = 0;
document.fonts.addEventListener("loadingdone", () => (fonts += 1));

class GlSurface implements Surface {
  readonly kind = "webgl2";
  readonly #sheets = Object.fromEntries(SHEETS.map((name) => [name, { list: new List(), matrix: null }])) as unknown as Record<SheetName, Recorded>;
  #shown = "";
  #generation = 0;
  #fonts = fonts;

  constructor(readonly canvas: HTMLCanvasElement, readonly renderer: GlRenderer) {}

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
    if (fonts !== this.#fonts) this.renderer.atlas.clear();
    this.#fonts = fonts;
    const { generation } = this.renderer;
    const isStale = generation !== this.#generation;
    this.#generation = generation;
    return isStale;
  }

  clear(): void {
    this.canvas.width = this.canvas.height = 1;
  }

  copyTo(context: OffscreenCanvasRenderingContext2D, camera: Camera): void {
    // The browser may have cleared the drawing buffer since: draw again.
    this.#shown = "";
    this.show(camera);
    context.drawImage(this.canvas, 0, 0);
  }
}
