// A 2D context that writes SVG, so that the layers draw a file with the code that draws them on the
// page. A bundle of its own, loaded when a drawing is first saved.
//
// The library does the drawing. Corrected here is what our layers need and the library lacks:
//
// | part of the context | the library | here |
// |---|---|---|
// | ellipses and arcs | turned the wrong way where y points up | cubic curves, right under any transform |
// | dashes | in pixels, whatever the scale | scaled, as on a canvas |
// | images | no OffscreenCanvas, always smoothed | accepted, with sharp cells if requested |
// | filling by the even-odd rule | ignored | supported |
// | fonts of texts | read by a style attribute, which our Content-Security-Policy forbids | read without |

import { Context } from "svgcanvas";

/** A cubic curve approximates up to a quarter of a circle within 3e-4 of its radius. */
const QUARTER = Math.PI / 2;

const ANCHORS: Readonly<Record<CanvasTextAlign, string>> = { left: "start", start: "start", center: "middle", right: "end", end: "end" };
const BASELINES: Readonly<Record<CanvasTextBaseline, string>> = {
  alphabetic: "alphabetic", hanging: "hanging", ideographic: "ideographic", top: "text-before-edge", middle: "central", bottom: "text-after-edge",
};

export class SvgContext extends Context {
  /** Filled with the background; sizes in CSS pixels. */
  constructor(width: number, height: number, background: string) {
    super(width, height);
    // Without it the drawing could not be scaled as a whole.
    this.getSvg().setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.fillStyle = background;
    this.fillRect(0, 0, width, height);
  }

  override ellipse(x: number, y: number, radiusX: number, radiusY: number, rotation: number, from: number, to: number, isBack = false): void {
    const [cos, sin] = [Math.cos(rotation), Math.sin(rotation)];
    const at = (u: number, v: number): [number, number] => [x + cos * radiusX * u - sin * radiusY * v, y + sin * radiusX * u + cos * radiusY * v];
    const sweep = sweepOf(from, to, isBack);
    const pieces = Math.max(1, Math.ceil(Math.abs(sweep) / QUARTER - 1e-9));
    const step = sweep / pieces;
    const handle = (4 / 3) * Math.tan(step / 4);
    this.lineTo(...at(Math.cos(from), Math.sin(from)));
    for (let i = 0; i < pieces; i += 1) {
      const [a, b] = [from + i * step, from + (i + 1) * step];
      const [ca, sa, cb, sb] = [Math.cos(a), Math.sin(a), Math.cos(b), Math.sin(b)];
      this.bezierCurveTo(...at(ca - handle * sa, sa + handle * ca), ...at(cb + handle * sb, sb - handle * cb), ...at(cb, sb));
    }
  }

  override arc(x: number, y: number, radius: number, from: number, to: number, isBack = false): void {
    this.ellipse(x, y, radius, radius, 0, from, to, isBack);
  }

  override setLineDash(lengths: readonly number[]): void {
    const { a, b } = this.getTransform();
    super.setLineDash(lengths.map((length) => length * Math.hypot(a, b)));
  }

  override fill(rule?: CanvasFillRule | Path2D): void {
    if (rule instanceof Path2D) throw new TypeError("a Path2D cannot be read: trace the path on the context");
    super.fill();
    if (rule !== undefined) this.__currentElement.setAttribute("fill-rule", rule);
  }

  override fillText(text: string, x: number, y: number): void {
    this.#write(text, x, y, { fill: String(this.fillStyle), stroke: "none" });
  }

  override strokeText(text: string, x: number, y: number): void {
    this.#write(text, x, y, { fill: "none", stroke: String(this.strokeStyle), "stroke-width": this.lineWidth, "stroke-linejoin": this.lineJoin });
  }

  #write(text: string, x: number, y: number, paint: Readonly<Record<string, string | number>>): void {
    const { a, b, c, d, e, f } = this.getTransform();
    const { style } = document.createElement("span");
    style.font = this.font;
    const attributes = {
      ...paint, x, y, opacity: this.globalAlpha, transform: `matrix(${[a, b, c, d, e, f].join(" ")})`,
      "font-family": style.fontFamily, "font-size": style.fontSize, "font-weight": style.fontWeight,
      "text-anchor": ANCHORS[this.textAlign], "dominant-baseline": BASELINES[this.textBaseline],
    };
    const element = document.createElementNS("http://www.w3.org/2000/svg", "text");
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
    element.textContent = text;
    this.__closestGroupOrSvg().append(element);
  }

  override drawImage(image: CanvasImageSource, ...place: number[]): void {
    const picture = image instanceof OffscreenCanvas ? copyOf(image) : image;
    const images = this.getSvg().getElementsByTagName("image");
    const count = images.length;
    (super.drawImage as (image: CanvasImageSource, ...place: number[]) => void).call(this, picture, ...place);
    if (!this.imageSmoothingEnabled) for (let i = count; i < images.length; i += 1) images[i]?.setAttribute("image-rendering", "pixelated");
  }
}

/** The angle of an arc, as on a canvas: a full turn at most. */
function sweepOf(from: number, to: number, isBack: boolean): number {
  const turn = 2 * Math.PI;
  const way = isBack ? from - to : to - from;
  const length = way >= turn ? turn : ((way % turn) + turn) % turn;
  return isBack ? -length : length;
}

function copyOf(picture: OffscreenCanvas): HTMLCanvasElement {
  const { width, height } = picture;
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  canvas.getContext("2d")?.drawImage(picture, 0, 0);
  return canvas;
}
