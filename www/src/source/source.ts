// The one shape that all sources of the worker share, and what they need of the module.

import { type Frame, type GridChange, type LogLevel, type SavedFile, SAMPLE, SAMPLE_STRIDE, type SourceKind, type Status, TRAIL_STRIDE } from "../protocol.js";

/** What changed since the last call; the worker adds run, number and pace. */
export type Change = Omit<Frame, "kind" | "run" | "seq" | "status">;

/** A status without the pace, which only the worker knows. */
export type Moment = Omit<Status, "realTimeFactor" | "remaining">;

export interface Note {
  time: number;
  level: LogLevel;
  text: string;
}

export interface Source {
  readonly kind: SourceKind;
  readonly title: string;
  /** Seconds of simulation or recording so far. */
  readonly time: number;
  readonly finished: boolean;
  /** Scans processed so far. */
  readonly scans: number;
  /** The smallest step forward. */
  step(): void;
  moment(): Moment;
  change(): Change;
  /** What happened since the last call, for the log. */
  notes(): Note[];
  hash(): string;
  files(): SavedFile[];
  close(): void;
}

/** Grid blocks as the module hands them over. */
export interface BlocksHandle {
  readonly revision: number;
  readonly index: Int32Array;
  readonly cells: Uint8Array;
  free(): void;
}

/** What a run in the module tells of its map, simulated or recorded. */
export interface MapHandle {
  grid_since(revision: number): BlocksHandle;
  /** Changes when the grid was drawn anew and old blocks are worth nothing. */
  grid_generation(): number;
  grid_resolution(): number;
  known_area(): number;
  half_size(): Float64Array;
  scan(): Float32Array;
  lines(): Float64Array;
  state_hash(): string;
  map_pgm(): Uint8Array;
  map_yaml(image: string): string;
  free(): void;
}

/** Cells along one side of a block of the module's grid. */
export const BLOCK_CELLS = 64;

/** Remembers how far the page knows the grid. */
export class GridFeed {
  #revision = 0;
  #generation = 0;

  next(map: MapHandle): { grid: GridChange | null; gridAnew: boolean } {
    const generation = map.grid_generation();
    const gridAnew = generation !== this.#generation;
    const blocks = map.grid_since(gridAnew ? 0 : this.#revision);
    this.#generation = generation;
    this.#revision = blocks.revision;
    const { index, cells } = blocks;
    blocks.free();
    const grid = index.length === 0 ? null : { resolution: map.grid_resolution(), blockCells: BLOCK_CELLS, index, cells };
    return { grid, gridAnew };
  }
}

/** A number that costs more than a step, asked for a few times a second only. */
export class Slow {
  static readonly PERIOD = 300;
  readonly #ask: () => number;
  #at = -Infinity;
  #value = NaN;

  constructor(ask: () => number) {
    this.#ask = ask;
  }

  get value(): number {
    const now = performance.now();
    if (now - this.#at > Slow.PERIOD) {
      this.#value = this.#ask();
      this.#at = performance.now();
    }
    return this.#value;
  }

  /** Asks again at the next look. */
  refresh(): void {
    this.#at = -Infinity;
  }
}

/** Three standard deviations of the position along its most uncertain direction, m. */
export function sigma3(xx: number, xy: number, yy: number): number {
  return 3 * Math.sqrt(Math.max(0, (xx + yy) / 2 + Math.hypot((xx - yy) / 2, xy)));
}

/** Three standard deviations of the heading, °. */
export function headingSigma3(variance: number): number {
  return (3 * Math.sqrt(Math.max(0, variance)) * 180) / Math.PI;
}

/** Collects numbers until a frame takes them. */
export class Samples {
  #values: number[] = [];

  add(sample: Record<keyof typeof SAMPLE, number>): void {
    const at = this.#values.length;
    this.#values.length = at + SAMPLE_STRIDE;
    for (const key of Object.keys(SAMPLE) as (keyof typeof SAMPLE)[]) this.#values[at + SAMPLE[key]] = sample[key];
  }

  take(): Float64Array | null {
    if (this.#values.length === 0) return null;
    const taken = Float64Array.from(this.#values);
    this.#values = [];
    return taken;
  }
}

/** Points of the trails, one for every few centimetres. */
export class Trail {
  static readonly SPACING = 0.03;
  #values: number[] = [];
  #last: [number, number] = [NaN, NaN];

  add(point: [number, number, number, number, number, number]): void {
    const [x, y] = [point[TRAIL_STRIDE - 2] ?? NaN, point[TRAIL_STRIDE - 1] ?? NaN];
    if (Math.hypot(x - this.#last[0], y - this.#last[1]) < Trail.SPACING) return;
    this.#last = [x, y];
    this.#values.push(...point);
  }

  take(): Float32Array | null {
    if (this.#values.length === 0) return null;
    const taken = Float32Array.from(this.#values);
    this.#values = [];
    return taken;
  }
}

/** The grid as ROS map_server files. */
export function mapFiles(map: MapHandle, name: string): SavedFile[] {
  const text = new TextEncoder();
  return [
    { name: `${name}.pgm`, mime: "image/x-portable-graymap", bytes: new Uint8Array(map.map_pgm()) },
    { name: `${name}.yaml`, mime: "application/yaml", bytes: text.encode(map.map_yaml(`${name}.pgm`)) },
  ];
}
