// A canvas that is not drawn anew for each picture, because that takes long. Until it is, the
// browser moves it with the camera.

import { Camera } from "./camera.js";

export class Sheet {
  /** What it shows, and since when, milliseconds; empty while it shows nothing. */
  shows = "";
  drawnAt = -Infinity;
  /** The view that it was drawn for. */
  readonly #camera = new Camera();
  #moved = "";

  /** It was drawn. */
  drawn(shows: string, camera: Camera, now: number): void {
    [this.shows, this.drawnAt] = [shows, now];
    Object.assign(this.#camera, camera);
  }

  /** Puts the canvas where what it shows belongs in this view. */
  move(canvas: HTMLElement, camera: Camera): void {
    const scale = camera.scale / this.#camera.scale;
    const [x, y] = camera.toScreen(...this.#camera.toMap(0, 0));
    const isThere = scale === 1 && Math.abs(x) < 1e-6 && Math.abs(y) < 1e-6;
    const moved = isThere || this.shows === "" ? "" : `matrix(${scale},0,0,${scale},${x},${y})`;
    if (moved !== this.#moved) canvas.style.setProperty("transform", moved);
    this.#moved = moved;
  }
}
