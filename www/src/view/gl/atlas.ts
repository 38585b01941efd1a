// Texts as images in one texture: each text is drawn once, in white, and coloured when it is used.

/** Side of the texture at first, and at most, pixels. */
const LEAST = 512;
const MOST = 4096;
/** Margin around each image, pixels. */
const MARGIN = 2;

/** A text in the texture, pixels; `left` and `rise` locate its reference point in it. */
export interface Glyphs { readonly x: number; readonly y: number; readonly width: number; readonly height: number; readonly left: number; readonly rise: number }

export class Atlas {
  readonly canvas = new OffscreenCanvas(LEAST, LEAST);
  /** Grows with each added text. */
  version = 0;
  /** Grows when the texture is cleared: all earlier places are then invalid. */
  generation = 0;
  #known = new Map<string, Glyphs>();
  /** Where the next text goes. */
  #x = 0;
  #y = 0;
  #row = 0;

  get #context(): OffscreenCanvasRenderingContext2D | null {
    return this.canvas.getContext("2d", { willReadFrequently: true });
  }

  /** Drops all texts, because there is no more room or fonts have been loaded. */
  clear(side = this.canvas.width): void {
    this.canvas.width = this.canvas.height = side;
    this.#known.clear();
    [this.#x, this.#y, this.#row] = [0, 0, 0];
    this.generation += 1;
    this.version += 1;
  }

  measure(font: string, text: string): TextMetrics | null {
    const context = this.#context;
    if (!context) return null;
    context.resetTransform();
    context.font = font;
    return context.measureText(text);
  }

  /** A text at `scale` device pixels per pixel of its font; `line` is the width of its outline, 0
      if it is filled. */
  glyphs(font: string, text: string, scale: number, line: number): Glyphs | null {
    const key = `${font}|${scale.toFixed(2)}|${line}|${text}`;
    return this.#known.get(key) ?? this.#write(key, font, text, scale, line);
  }

  #write(key: string, font: string, text: string, scale: number, line: number): Glyphs | null {
    const metrics = this.measure(font, text);
    const context = this.#context;
    if (!metrics || !context) return null;
    const [left, rise] = [Math.ceil(scale * (metrics.actualBoundingBoxLeft + line)) + MARGIN, Math.ceil(scale * (metrics.actualBoundingBoxAscent + line)) + MARGIN];
    const width = left + Math.ceil(scale * (metrics.actualBoundingBoxRight + line)) + MARGIN;
    const height = rise + Math.ceil(scale * (metrics.actualBoundingBoxDescent + line)) + MARGIN;
    if (this.#x + width > this.canvas.width) [this.#x, this.#y, this.#row] = [0, this.#y + this.#row, 0];
    if (this.#y + height > this.canvas.height || width > this.canvas.width) {
      // Too large even for an empty texture of the largest size: clearing would not help.
      if (this.canvas.width >= MOST && (this.#known.size === 0 || width > MOST)) return null;
      this.clear(Math.min(2 * this.canvas.width, MOST));
      return this.#write(key, font, text, scale, line);
    }
    const glyphs = { x: this.#x, y: this.#y, width, height, left, rise };
    context.setTransform(scale, 0, 0, scale, this.#x + left, this.#y + rise);
    context.fillStyle = context.strokeStyle = "#fff";
    context.lineWidth = line;
    if (line > 0) context.strokeText(text, 0, 0);
    else context.fillText(text, 0, 0);
    this.#x += width;
    this.#row = Math.max(this.#row, height);
    this.#known.set(key, glyphs);
    this.version += 1;
    return glyphs;
  }
}
