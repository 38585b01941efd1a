// Decides whether the map is drawn with WebGL2 or with Canvas 2D.
//
// | graphics card | drawn with | why |
// |---|---|---|
// | present | WebGL2 | the page's main thread has hardly anything to do |
// | emulated by the processor | Canvas 2D | measured on two cores: 60 pictures a second, not 10 |
// | none, or taken away | Canvas 2D | until it is given back |
//
// A person can choose otherwise; the browser remembers that.

import { bundle } from "../bundle.js";
import { ifAllowed } from "../storage.js";
import type { Store } from "../store.js";
import { t } from "../words.js";
import type { Surface } from "./surface.js";

export const DRAWINGS = ["auto", "webgl2", "canvas"] as const;
export type Drawing = (typeof DRAWINGS)[number];

const KEY = "slamlab-drawn-with";
/** Names of graphics cards that are emulated. */
const EMULATED = /swiftshader|llvmpipe|softpipe|software|basic render/i;

let chosen: Drawing = DRAWINGS.find((name) => name === ifAllowed(() => localStorage.getItem(KEY))) ?? "auto";
const choice = new EventTarget();

export function chosenDrawing(): Drawing {
  return chosen;
}

export function chooseDrawing(drawing: Drawing): void {
  chosen = drawing;
  ifAllowed(() => localStorage.setItem(KEY, drawing));
  choice.dispatchEvent(new Event("change"));
}

export interface Hearer {
  /** There is a graphics card to draw with. */
  came(surface: Surface): void;
  /** There is none to draw with, for this reason. `isLoss`: there was one. */
  went(why: string, isLoss: boolean): void;
}

/** Reports whether WebGL2 is available, and every change of that, with a canvas that replaces
    `place`. The canvas is hidden while unused: browsers show a sad face on one that has lost its
    context. */
export class Graphics {
  #canvas: HTMLCanvasElement;
  #gl: WebGL2RenderingContext | null = null;
  readonly #again = (): void => this.begin();

  constructor(place: HTMLCanvasElement, readonly store: Store, readonly hearer: Hearer) {
    this.#canvas = place;
  }

  /** Begins, or begins again. */
  begin(): void {
    this.end();
    choice.addEventListener("change", this.#again);
    if (chosen === "canvas") return this.hearer.went("so it was chosen", false);
    // A canvas gives no other context than its first one.
    const canvas = this.#canvas.cloneNode() as HTMLCanvasElement;
    this.#canvas.replaceWith(canvas);
    this.#canvas = canvas;
    const gl = canvas.getContext("webgl2", { alpha: true, antialias: false, depth: true, stencil: true, failIfMajorPerformanceCaveat: chosen === "auto" });
    if (!gl) return this.hearer.went("this browser gives no WebGL2", false);
    this.#gl = gl;
    if (chosen === "auto" && isEmulated(gl)) {
      this.#release();
      return this.hearer.went("the graphics card is emulated by the processor here, which takes longer", false);
    }
    canvas.addEventListener("webglcontextlost", (event) => {
      if (this.#gl !== gl) return;
      // Without this it would never be given back.
      event.preventDefault();
      canvas.hidden = true;
      this.hearer.went("the graphics card was taken away", true);
    });
    canvas.addEventListener("webglcontextrestored", () => void this.#use(gl));
    void this.#use(gl);
  }

  /** Releases the context: a browser allows only so many. */
  end(): void {
    choice.removeEventListener("change", this.#again);
    this.#release();
  }

  #release(): void {
    const gl = this.#gl;
    this.#gl = null;
    this.#canvas.hidden = true;
    gl?.getExtension("WEBGL_lose_context")?.loseContext();
  }

  async #use(gl: WebGL2RenderingContext): Promise<void> {
    const part = await bundle(this.store, "gl.js", "The part that draws with WebGL2") as typeof import("./gl/surface.js") | null;
    // Another choice may have been made meanwhile.
    if (this.#gl !== gl) return;
    if (!part) return this.hearer.went("the part of the page that draws with it did not come", false);
    try {
      const surface = part.surfaceOn(this.#canvas, gl);
      if (!surface) return;
      this.#canvas.hidden = false;
      this.hearer.came(surface);
    } catch (fault) {
      this.#release();
      this.hearer.went(t`the graphics card does not take its programs: ${(fault as Error).message}`, false);
    }
  }
}

function isEmulated(gl: WebGL2RenderingContext): boolean {
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  return info !== null && EMULATED.test(String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)));
}
