// Grid cells as images: tiles of 8 x 8 blocks, which only have to be stretched to be drawn. Each
// back end keeps its own image of a tile, a canvas or a texture, and updates the blocks that have
// changed.

import type { FieldName, GridChange } from "../protocol/module.js";
import { type Box, union } from "./camera.js";
import { type Palette, type Rgb, rgb } from "./palette.js";

/** What the grid shows: how certain each cell is, the same in three tones as saved, or a field. */
export type GridView = "continuous" | "three" | FieldName;

/** What tiles show: one of these, or the obstacles of the map by odometry alone. */
export type TileView = GridView | "wheels";

const BLOCKS_PER_TILE = 8;
/** A cell is an obstacle above this probability, and free below 1 minus it; as in ROS
    map_server. */
const OCCUPIED = 0.65;
const EVERYWHERE: Box = { minX: -Infinity, minY: -Infinity, maxX: Infinity, maxY: Infinity };

export interface Tile {
  readonly col: number;
  readonly row: number;
  readonly blocks: Map<string, Block>;
}

export interface Block {
  readonly col: number;
  readonly row: number;
  readonly cells: Uint8Array;
  /** The rectangle of its known cells, m; null if there are none. */
  readonly box: Box | null;
  /** The version of the tiles at its last change of a pixel. */
  version: number;
}

/** The image of a tile, and the version up to which it is painted. */
interface Painted { readonly canvas: OffscreenCanvas; upTo: number }

export class Tiles {
  resolution = 0.05;
  blockCells = 64;
  /** Grows with every change of a pixel. */
  version = 0;
  #blocks = new Map<string, Block>();
  #tiles = new Map<string, Tile>();
  #colours: Uint32Array = new Uint32Array(256);
  #key = "";
  #canvases = new WeakMap<Tile, Painted>();
  #image: ImageData | null = null;
  #changed: Box | null = null;

  clear(): void {
    this.#blocks.clear();
    this.#tiles.clear();
    this.#changed = EVERYWHERE;
    this.version += 1;
  }

  /** Where pixels changed since the last call; infinite if all did. */
  takeChanged(): Box | null {
    const changed = this.#changed;
    this.#changed = null;
    return changed;
  }

  get size(): number {
    return this.#blocks.size;
  }

  /** Pixels along a side of a tile. */
  get tileCells(): number {
    return this.blockCells * BLOCKS_PER_TILE;
  }

  all(): Iterable<Tile> {
    return this.#tiles.values();
  }

  take(change: GridChange): void {
    this.resolution = change.resolution;
    this.blockCells = change.blockCells;
    const area = change.blockCells * change.blockCells;
    for (let i = 0; i * 2 + 1 < change.index.length; i += 1) {
      const [col, row] = [change.index[i * 2] ?? 0, change.index[i * 2 + 1] ?? 0];
      const cells = change.cells.slice(i * area, (i + 1) * area);
      const block = { col, row, cells, box: this.#boxOf(col, row, cells), version: this.version + 1 };
      this.#blocks.set(`${col},${row}`, block);
      this.#tileOf(block).blocks.set(`${col},${row}`, block);
      this.#changed = union(this.#changed, this.#whole(col, row));
    }
    this.version += 1;
  }

  /** Chooses colours; repaints everything if they differ from the present ones. */
  colour(palette: Palette, view: TileView): void {
    const key = JSON.stringify([palette.tones, palette.css.field, palette.css.odometry, view]);
    if (key === this.#key) return;
    this.#key = key;
    this.#colours = tableFor(palette, view);
    this.version += 1;
    for (const block of this.#blocks.values()) block.version = this.version;
    this.#changed = EVERYWHERE;
  }

  /** Probability of an obstacle at a map point; null if nothing is known. */
  probabilityAt(x: number, y: number): number | null {
    const value = this.byteAt(x, y);
    return value === 0 ? null : (value - 1) / 254;
  }

  /** The value of the cell at a map point; 0 if it is unknown. */
  byteAt(x: number, y: number): number {
    const side = this.blockCells;
    const [col, row] = [Math.floor(x / this.resolution), Math.floor(y / this.resolution)];
    const block = this.#blocks.get(`${Math.floor(col / side)},${Math.floor(row / side)}`);
    return block?.cells[modulo(row, side) * side + modulo(col, side)] ?? 0;
  }

  /** The rectangle of everything known, to a cell; null if nothing is. */
  bounds(): Box | null {
    let all: Box | null = null;
    for (const { box } of this.#blocks.values()) if (box !== null) all = union(all, box);
    return all;
  }

  #whole(col: number, row: number): Box {
    const side = this.blockCells * this.resolution;
    return { minX: col * side, minY: row * side, maxX: (col + 1) * side, maxY: (row + 1) * side };
  }

  #boxOf(col: number, row: number, cells: Uint8Array): Box | null {
    const side = this.blockCells;
    let [minC, minR, maxC, maxR] = [side, side, -1, -1];
    for (let r = 0, i = 0; r < side; r += 1) {
      for (let c = 0; c < side; c += 1, i += 1) {
        if (cells[i] === 0) continue;
        if (c < minC) minC = c;
        if (c > maxC) maxC = c;
        if (r < minR) minR = r;
        maxR = r;
      }
    }
    if (maxC < 0) return null;
    return {
      minX: (col * side + minC) * this.resolution,
      minY: (row * side + minR) * this.resolution,
      maxX: (col * side + maxC + 1) * this.resolution,
      maxY: (row * side + maxR + 1) * this.resolution,
    };
  }

  #tileOf({ col, row }: Block): Tile {
    const [tileCol, tileRow] = [Math.floor(col / BLOCKS_PER_TILE), Math.floor(row / BLOCKS_PER_TILE)];
    const key = `${tileCol},${tileRow}`;
    const tile = this.#tiles.get(key) ?? { col: tileCol, row: tileRow, blocks: new Map<string, Block>() };
    this.#tiles.set(key, tile);
    return tile;
  }

  /** The position of a block in its tile, from the upper left corner, pixels. Tiles hold rows from
      the top, blocks from the bottom: the camera's one flip of y would leave every tile upside
      down. */
  placeOf({ col, row }: Block): [number, number] {
    return [modulo(col, BLOCKS_PER_TILE) * this.blockCells, (BLOCKS_PER_TILE - 1 - modulo(row, BLOCKS_PER_TILE)) * this.blockCells];
  }

  /** A block in colours, rows from the top; the next call overwrites it. */
  pixelsOf(block: Block): ImageData {
    const side = this.blockCells;
    if (this.#image?.width !== side) this.#image = new ImageData(side, side);
    const pixels = new Uint32Array(this.#image.data.buffer);
    for (let row = 0; row < side; row += 1) {
      const from = (side - 1 - row) * side;
      for (let col = 0; col < side; col += 1) pixels[row * side + col] = this.#colours[block.cells[from + col] ?? 0] ?? 0;
    }
    return this.#image;
  }

  /** A tile as an image. */
  canvasOf(tile: Tile): OffscreenCanvas {
    const painted = this.#canvases.get(tile) ?? { canvas: new OffscreenCanvas(this.tileCells, this.tileCells), upTo: 0 };
    this.#canvases.set(tile, painted);
    const context = painted.canvas.getContext("2d");
    for (const block of tile.blocks.values()) {
      if (block.version > painted.upTo) context?.putImageData(this.pixelsOf(block), ...this.placeOf(block));
    }
    painted.upTo = this.version;
    return painted.canvas;
  }
}

function tableFor(palette: Palette, view: TileView): Uint32Array {
  switch (view) {
    case "continuous":
    case "three":
      return colourTable(palette, view === "three");
    case "wheels":
      return wheelsTable(palette);
    default:
      return fieldTable(palette, view);
  }
}

/** Obstacles in the colour of odometry; everything else is transparent. */
function wheelsTable(palette: Palette): Uint32Array {
  const hue = packed(rgb(palette.css.odometry));
  return Uint32Array.from({ length: 256 }, (_, byte) => ((byte - 1) / 254 > OCCUPIED ? hue : 0));
}

function colourTable(palette: Palette, threeTones: boolean): Uint32Array {
  const { unknown, free, occupied } = palette.tones;
  return tableOf((p) => {
    // Full tone once the state is decided, so that a room looks the same after two observations and
    // after twenty.
    const certainty = threeTones ? (p > OCCUPIED || p < 1 - OCCUPIED ? 1 : 0) : Math.min(1, Math.abs(p - 0.5) * 2.6);
    return mix(unknown, p > 0.5 ? occupied : free, certainty);
  });
}

/** A distance goes from the field's own hue at walls to the tone of free cells; a likelihood the
    other way round. Where the robot has no room, the tone is that of occupied cells. */
function fieldTable(palette: Palette, view: FieldName): Uint32Array {
  const { free, occupied } = palette.tones;
  const hue = rgb(palette.css.field);
  return tableOf((part) => {
    if (view === "likelihood") return mix(free, hue, part);
    if (view === "room" && part === 0) return occupied;
    // Distances matter most near walls.
    return mix(hue, free, Math.sqrt(part));
  });
}

/** The colours of all bytes: 0 is unknown, the others are values from 0 to 1. */
function tableOf(colour: (part: number) => Rgb): Uint32Array {
  return Uint32Array.from({ length: 256 }, (_, byte) => (byte === 0 ? 0 : packed(colour((byte - 1) / 254))));
}

export function mix(from: Rgb, to: Rgb, part: number): Rgb {
  const at = (i: 0 | 1 | 2): number => Math.round(from[i] + (to[i] - from[i]) * part);
  return [at(0), at(1), at(2)];
}

export function packed([r, g, b]: Rgb): number {
  return ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;
}

function modulo(a: number, n: number): number {
  return ((a % n) + n) % n;
}
