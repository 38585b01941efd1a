// Map metres to canvas pixels and back: the only place that flips y.

export interface Box {
  minX: number;
  minY: number;
  maxX: number;
  maxY: number;
}

/** The smallest box around both. */
export function union(a: Box | null, b: Box): Box {
  if (a === null) return b;
  return { minX: Math.min(a.minX, b.minX), minY: Math.min(a.minY, b.minY), maxX: Math.max(a.maxX, b.maxX), maxY: Math.max(a.maxY, b.maxY) };
}

export class Camera {
  /** Map point in the middle of the free part of the canvas, m. */
  x = 0;
  y = 0;
  /** CSS pixels for each metre. */
  scale = 48;
  /** Size of the canvas, CSS pixels. */
  width = 1;
  height = 1;
  /** Device pixels for each CSS pixel. */
  ratio = 1;
  /** CSS pixels at each side that panels cover. */
  inset = { top: 0, right: 0, bottom: 0, left: 0 };

  static readonly MIN_SCALE = 2;
  static readonly MAX_SCALE = 800;

  toScreen(x: number, y: number): [number, number] {
    return [this.#middleX + (x - this.x) * this.scale, this.#middleY - (y - this.y) * this.scale];
  }

  toMap(screenX: number, screenY: number): [number, number] {
    return [this.x + (screenX - this.#middleX) / this.scale, this.y - (screenY - this.#middleY) / this.scale];
  }

  /** After this the context draws in metres, y up; `px` gives widths. */
  applyTo(context: CanvasRenderingContext2D): void {
    const k = this.scale * this.ratio;
    const [x, y] = this.toScreen(0, 0);
    context.setTransform(k, 0, 0, -k, x * this.ratio, y * this.ratio);
  }

  /** Length in metres that is `n` CSS pixels on the canvas. */
  px(n: number): number {
    return n / this.scale;
  }

  panBy(screenX: number, screenY: number): void {
    this.x -= screenX / this.scale;
    this.y += screenY / this.scale;
  }

  /** Zooms so that the map point under the given pixel stays there. */
  zoomAt(factor: number, screenX: number, screenY: number): void {
    const [x, y] = this.toMap(screenX, screenY);
    this.scale = clamp(this.scale * factor, Camera.MIN_SCALE, Camera.MAX_SCALE);
    const [newX, newY] = this.toMap(screenX, screenY);
    this.x += x - newX;
    this.y += y - newY;
  }

  /** The view that shows all of `box`, with at most `maxScale`. */
  fitted(box: Box, maxScale = 90): { x: number; y: number; scale: number } {
    const width = Math.max(this.width - this.inset.left - this.inset.right, 40);
    const height = Math.max(this.height - this.inset.top - this.inset.bottom, 40);
    const scale = Math.min(width / Math.max(box.maxX - box.minX, 0.5), height / Math.max(box.maxY - box.minY, 0.5));
    return {
      x: (box.minX + box.maxX) / 2,
      y: (box.minY + box.maxY) / 2,
      scale: clamp(scale * 0.95, Camera.MIN_SCALE, maxScale),
    };
  }

  get visible(): Box {
    const [minX, maxY] = this.toMap(0, 0);
    const [maxX, minY] = this.toMap(this.width, this.height);
    return { minX, minY, maxX, maxY };
  }

  get #middleX(): number {
    return (this.inset.left + this.width - this.inset.right) / 2;
  }

  get #middleY(): number {
    return (this.inset.top + this.height - this.inset.bottom) / 2;
  }
}

export function clamp(value: number, low: number, high: number): number {
  return Math.min(Math.max(value, low), high);
}
