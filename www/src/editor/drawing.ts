// A world that is being drawn: the contents of its file, and how its parts are added, changed and
// removed. Nothing is changed in place, so an earlier drawing can be restored. Metres and radians,
// x right, y up, as in the file.

export type Point = readonly [number, number];
export type Material = "opaque" | "glass" | "dark";

export interface Polyline { readonly shape: "polyline"; readonly points: readonly Point[]; readonly closed?: boolean; readonly material?: Material }
export interface Polygon { readonly shape: "polygon"; readonly points: readonly Point[]; readonly material?: Material }
export interface Rectangle { readonly shape: "rectangle"; readonly centre: Point; readonly size: Point; readonly angle?: number; readonly material?: Material }
export interface Circle { readonly shape: "circle"; readonly centre: Point; readonly radius: number; readonly material?: Material }
export type Obstacle = Polyline | Polygon | Rectangle | Circle;

export interface Door { readonly from: Point; readonly to: Point; readonly open?: boolean; readonly switches?: readonly number[] }
export interface Mover { readonly waypoints: readonly Point[]; readonly closed?: boolean; readonly speed: number; readonly radius: number; readonly pause?: number }
export interface Start { readonly x: number; readonly y: number; readonly heading?: number }
export interface Goal { readonly x: number; readonly y: number }

/** A world file, field by field (core/src/format/world.schema.json). */
export interface Drawing {
  readonly slamlab_world: 1;
  readonly name: string;
  readonly start: Start;
  readonly goal?: Goal;
  readonly robot?: "rp6" | "pioneer";
  readonly sensor?: "lidar" | "sick" | "rangers" | "sonar";
  readonly seed?: number;
  readonly obstacles: readonly Obstacle[];
  readonly doors?: readonly Door[];
  readonly movers?: readonly Mover[];
}

/** A reference to a part of a drawing: one of several, by its index, or a part that exists once. */
export type PartRef =
  | { readonly kind: "obstacle" | "door" | "mover"; readonly index: number }
  | { readonly kind: "start" | "goal" };

export type Part =
  | { readonly kind: "obstacle"; readonly value: Obstacle }
  | { readonly kind: "door"; readonly value: Door }
  | { readonly kind: "mover"; readonly value: Mover }
  | { readonly kind: "start"; readonly value: Start }
  | { readonly kind: "goal"; readonly value: Goal };

export const EMPTY: Drawing = { slamlab_world: 1, name: "my world", start: { x: 0, y: 0, heading: 0 }, obstacles: [] };

/** The drawing of a file that the core has read; what the core has not read, its check reports. */
export function parsed(text: string): Drawing {
  return JSON.parse(text) as Drawing;
}

/** The drawing as the text of its file. */
export function written(drawing: Drawing): string {
  return `${JSON.stringify(drawing, null, 1)}\n`;
}

export function sameRef(a: PartRef | null, b: PartRef | null): boolean {
  if (a === null || b === null || a.kind !== b.kind) return a === b;
  return !("index" in a) || !("index" in b) || a.index === b.index;
}

/** All parts; the topmost comes last. */
export function partsOf(drawing: Drawing): PartRef[] {
  const refs = (kind: "obstacle" | "door" | "mover", list: readonly unknown[] = []): PartRef[] => list.map((_, index) => ({ kind, index }));
  return [...refs("obstacle", drawing.obstacles), ...refs("door", drawing.doors), ...refs("mover", drawing.movers), ...(drawing.goal ? [{ kind: "goal" } as const] : []), { kind: "start" }];
}

/** The part that a reference means; null if there is none. */
export function partAt(drawing: Drawing, ref: PartRef): Part | null {
  switch (ref.kind) {
    case "start": return { kind: "start", value: drawing.start };
    case "goal": return drawing.goal ? { kind: "goal", value: drawing.goal } : null;
    case "obstacle": return part("obstacle", drawing.obstacles[ref.index]);
    case "door": return part("door", drawing.doors?.[ref.index]);
    case "mover": return part("mover", drawing.movers?.[ref.index]);
  }
}

function part<K extends Part["kind"]>(kind: K, value: Extract<Part, { kind: K }>["value"] | undefined): Part | null {
  return value === undefined ? null : ({ kind, value } as Part);
}

/** With one more part, and the reference to it. Start and goal replace the existing ones. */
export function added(drawing: Drawing, { kind, value }: Part): [Drawing, PartRef] {
  switch (kind) {
    case "start": return [{ ...drawing, start: value }, { kind }];
    case "goal": return [{ ...drawing, goal: value }, { kind }];
    case "obstacle": return [{ ...drawing, obstacles: [...drawing.obstacles, value] }, { kind, index: drawing.obstacles.length }];
    case "door": return [{ ...drawing, doors: [...(drawing.doors ?? []), value] }, { kind, index: drawing.doors?.length ?? 0 }];
    case "mover": return [{ ...drawing, movers: [...(drawing.movers ?? []), value] }, { kind, index: drawing.movers?.length ?? 0 }];
  }
}

/** The drawing with another value of one part. */
export function replaced(drawing: Drawing, ref: PartRef, next: Part): Drawing {
  const put = <T>(list: readonly T[] | undefined, index: number, value: T): T[] => (list ?? []).map((old, at) => (at === index ? value : old));
  switch (next.kind) {
    case "start": return { ...drawing, start: next.value };
    case "goal": return { ...drawing, goal: next.value };
    case "obstacle": return "index" in ref ? { ...drawing, obstacles: put(drawing.obstacles, ref.index, next.value) } : drawing;
    case "door": return "index" in ref ? { ...drawing, doors: put(drawing.doors, ref.index, next.value) } : drawing;
    case "mover": return "index" in ref ? { ...drawing, movers: put(drawing.movers, ref.index, next.value) } : drawing;
  }
}

/** The drawing without one part. The start stays, because the robot has to start somewhere. */
export function removed(drawing: Drawing, ref: PartRef): Drawing {
  const without = <T>(list: readonly T[] | undefined, index: number): T[] => (list ?? []).filter((_, at) => at !== index);
  switch (ref.kind) {
    case "start": return drawing;
    case "goal": {
      const { goal: _, ...rest } = drawing;
      return rest;
    }
    case "obstacle": return { ...drawing, obstacles: without(drawing.obstacles, ref.index) };
    case "door": return { ...drawing, doors: without(drawing.doors, ref.index) };
    case "mover": return { ...drawing, movers: without(drawing.movers, ref.index) };
  }
}
