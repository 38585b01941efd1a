// Saves files for the person: downloads, and the map as an image.

import type { SavedFile } from "./protocol/module.js";
import type { Tiles } from "./view/tiles.js";

/** Wall milliseconds between two downloads: browsers drop the first if the second follows at
    once. */
const SPACING = 250;

export function downloadAll(files: readonly SavedFile[]): void {
  files.forEach((file, i) => setTimeout(() => download(new Blob([file.bytes], { type: file.mime }), file.name), i * SPACING));
}

/** The run's title as a file name, without extension. */
export function fileName(title: string): string {
  return title.replace(/[^\w-]+/g, "-") || "map";
}

export function download(blob: Blob, name: string): void {
  const url = URL.createObjectURL(blob);
  const link = document.createElement("a");
  link.href = url;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** The grid as it is drawn, one pixel per cell; null while nothing is known. */
export async function mapPicture(tiles: Tiles, background: string): Promise<Blob | null> {
  const box = tiles.bounds();
  if (!box) return null;
  const { resolution, tileCells } = tiles;
  const margin = 10;
  const cells = (length: number): number => Math.round(length / resolution);
  const picture = new OffscreenCanvas(cells(box.maxX - box.minX) + 2 * margin, cells(box.maxY - box.minY) + 2 * margin);
  const context = picture.getContext("2d");
  if (!context) return null;
  context.fillStyle = background;
  context.fillRect(0, 0, picture.width, picture.height);
  for (const tile of tiles.all()) {
    const x = tile.col * tileCells - cells(box.minX) + margin;
    const y = cells(box.maxY) - (tile.row + 1) * tileCells + margin;
    context.drawImage(tiles.canvasOf(tile), x, y);
  }
  return picture.convertToBlob({ type: "image/png" });
}
