// State and actions of the world editor, without a page around it: the drawing and its history, the
// current tool, the part being drawn, what is chosen and what is wrong.

import type { WorldFault } from "../protocol/module.js";
import { dragged, type Handle, handlesOf, middleOf, moved, rotated } from "./change.js";
import { added, type Drawing, EMPTY, type Material, type Part, partAt, type PartRef, partsOf, type Point, removed, replaced, sameRef } from "./drawing.js";
import { distance, distanceTo, endsOf, minus, partNear } from "./outline.js";
import { Past } from "./past.js";
import { gridOf, type Snapped, snapped } from "./snap.js";
import { type Draft, made, type ToolName, TOOLS } from "./tools.js";

/** How near a pointer has to be to hit something, pixels. */
const REACH = 11;
/** Turns snap to multiples of this, rad. */
const TURN_STEP = Math.PI / 12;
/** Distance of the turning handle, pixels. */
const ARM = 30;

/** What a press holds while the pointer moves. */
type Held =
  | { readonly what: "handle"; readonly handle: Handle; readonly part: Part; readonly ref: PartRef }
  | { readonly what: "part"; readonly part: Part; readonly ref: PartRef }
  | { readonly what: "view" }
  | { readonly what: "draft" };

export class EditorModel {
  #past = new Past(EMPTY);
  #listeners: (() => void)[] = [];
  #gestures = 0;
  #held: Held | null = null;
  tool: ToolName = "wall";
  material: Material = "opaque";
  /** Whether points snap to ends, right angles and the grid. */
  snaps = true;
  /** Whether a key suspends snapping for the moment. */
  isHeldOff = false;
  chosen: PartRef | null = null;
  draft: Draft | null = null;
  cursor: Snapped | null = null;
  fault: WorldFault | null = null;

  on(listener: () => void): void {
    this.#listeners.push(listener);
  }

  notify(): void {
    for (const listener of this.#listeners) listener();
  }

  get drawing(): Drawing {
    return this.#past.drawing;
  }

  get canUndo(): boolean {
    return this.draft !== null || this.#past.canUndo;
  }

  get canRedo(): boolean {
    return this.#past.canRedo;
  }

  /** Opens another drawing; the one before is one undo step back. */
  open(drawing: Drawing): void {
    this.#past.put(drawing);
    this.chosen = this.draft = null;
    this.notify();
  }

  /** Begins with this drawing: there is no earlier one. */
  begin(drawing: Drawing): void {
    this.#past = new Past(drawing);
    this.notify();
  }

  take(tool: ToolName): void {
    this.finish(false);
    this.tool = tool;
    if (tool !== "select") this.chosen = null;
    this.notify();
  }

  choose(ref: PartRef | null): void {
    this.chosen = ref;
    this.#past.pause();
    this.notify();
  }

  /** Chooses the next or the previous part. */
  chooseNext(by: 1 | -1): void {
    const refs = partsOf(this.drawing);
    const at = refs.findIndex((ref) => sameRef(ref, this.chosen));
    this.take("select");
    this.choose(refs[at < 0 ? (by > 0 ? 0 : refs.length - 1) : (at + by + refs.length) % refs.length] ?? null);
  }

  get chosenPart(): Part | null {
    return this.chosen && partAt(this.drawing, this.chosen);
  }

  /** The part with the error, if the error is in one. */
  get wrong(): PartRef | null {
    const { part = "", index = null } = this.fault ?? {};
    if (part === "start" || part === "goal") return { kind: part };
    return (part === "obstacle" || part === "door" || part === "mover") && index !== null ? { kind: part, index } : null;
  }

  showWrong(): void {
    const { wrong } = this;
    this.take("select");
    this.choose(wrong);
  }

  handles(scale: number): Handle[] {
    const part = this.tool === "select" ? this.chosenPart : null;
    return part ? handlesOf(part, ARM / scale) : [];
  }

  /** Sets another value of the chosen part. Steps of one gesture are undone together. */
  change(part: Part, gesture: string | null = null): void {
    if (this.chosen) this.#past.put(replaced(this.drawing, this.chosen, part), gesture);
    this.notify();
  }

  rename(name: string): void {
    this.#past.put({ ...this.drawing, name });
    this.notify();
  }

  move(by: Point, gesture: string | null = null): void {
    const part = this.chosenPart;
    if (part) this.change(moved(part, by), gesture);
  }

  turn(angle: number): void {
    const part = this.chosenPart;
    if (part) this.change(rotated(part, angle));
  }

  duplicate(): void {
    const part = this.chosenPart;
    if (!part || part.kind === "start" || part.kind === "goal") return;
    const [drawing, ref] = added(this.drawing, moved(part, [0.5, -0.5]));
    this.#past.put(drawing);
    this.choose(ref);
  }

  remove(): void {
    if (!this.chosen) return;
    this.#past.put(removed(this.drawing, this.chosen));
    this.choose(null);
  }

  undo(): void {
    if (this.draft) {
      const points = this.draft.points.slice(0, -1);
      this.draft = points.length > 0 ? { ...this.draft, points } : null;
    } else this.#past.undo();
    this.#forgetLost();
  }

  redo(): void {
    this.#past.redo();
    this.#forgetLost();
  }

  #forgetLost(): void {
    if (!this.chosenPart) this.chosen = null;
    this.notify();
  }

  /** The snapped position of a point at this magnification. */
  snap(point: Point, scale: number, but: PartRef | null = null): Snapped {
    if (!this.snaps || this.isHeldOff) return snapped(point, null);
    const points = this.draft?.points ?? [];
    const ends = [...endsOf(this.drawing, but), ...points.slice(0, -1)];
    return snapped(point, { ends, from: points.at(-1) ?? null, before: points.at(-2) ?? null, grid: gridOf(scale), reach: REACH / scale });
  }

  hover(point: Point, scale: number): void {
    this.cursor = this.tool === "select" ? null : this.snap(point, scale);
    this.notify();
  }

  leave(): void {
    this.cursor = null;
    this.notify();
  }

  /** A press without a move. */
  tap(point: Point, scale: number): void {
    if (this.tool === "select") return this.choose(partNear(this.drawing, point, REACH / scale));
    const at = this.snap(point, scale);
    this.cursor = at;
    this.set(at.point, REACH / scale);
  }

  /** Places a point with the current tool; one on the last or the first point ends the draft. */
  set(point: Point, reach: number): void {
    const { takes } = TOOLS[this.tool];
    const points = this.draft?.points ?? [];
    const isAt = (other: Point | undefined): boolean => other !== undefined && distance(other, point) < reach;
    if (takes === "many" && points.length > 0 && isAt(points.at(-1))) return this.finish(false);
    if (takes === "many" && points.length > 2 && isAt(points[0])) return this.finish(true);
    this.draft = { tool: this.tool, points: [...points, point] };
    if (takes !== "many" && this.draft.points.length >= Number(takes)) this.finish(false);
    else this.notify();
  }

  /** Turns the draft into a part, if its points make one. */
  finish(closed: boolean): void {
    const { draft } = this;
    this.draft = null;
    const part = draft && made(draft, this.material, closed);
    if (part) this.#past.put(added(this.drawing, part)[0]);
    this.notify();
  }

  cancel(): void {
    this.draft = null;
    this.notify();
  }

  /** A press moves, from where it began to where it is. Returns whether that moves the view. */
  drag(from: Point, to: Point, scale: number): boolean {
    this.#held ??= this.#grab(from, scale);
    const held = this.#held;
    const gesture = `drag ${this.#gestures}`;
    switch (held.what) {
      case "view": return true;
      case "draft":
        this.cursor = this.snap(to, scale);
        this.notify();
        return false;
      case "handle": {
        const at = held.handle.what === "corner" ? this.snap(to, scale, held.ref).point : to;
        this.cursor = held.handle.what === "corner" ? { point: at, to: "nothing" } : null;
        this.change(dragged(held.part, held.handle, at, this.snaps && !this.isHeldOff ? TURN_STEP : 0), gesture);
        return false;
      }
      case "part": {
        const middle = middleOf(held.part);
        const grid = gridOf(scale);
        const by = minus(to, from);
        const isFree = !this.snaps || this.isHeldOff;
        const step = (value: number): number => (isFree ? value : Math.round(value / grid) * grid);
        this.change(moved(held.part, [step(middle[0] + by[0]) - step(middle[0]), step(middle[1] + by[1]) - step(middle[1])]), gesture);
        return false;
      }
    }
  }

  #grab(from: Point, scale: number): Held {
    this.#gestures += 1;
    const reach = REACH / scale;
    if (this.tool !== "select") {
      if (!this.draft) this.draft = { tool: this.tool, points: [this.snap(from, scale).point] };
      return { what: "draft" };
    }
    const part = this.chosenPart;
    const handle = this.handles(scale).find(({ at }) => distance(at, from) < 1.4 * reach);
    if (this.chosen && part && handle) return { what: "handle", handle, part, ref: this.chosen };
    const ref = part && this.chosen && distanceTo(part, from) <= reach ? this.chosen : partNear(this.drawing, from, reach);
    const held = ref && partAt(this.drawing, ref);
    if (!ref || !held) return { what: "view" };
    this.choose(ref);
    return { what: "part", part: held, ref };
  }

  /** The press has ended; with `isDone` false it is cancelled. */
  drop(isDone: boolean, scale: number): void {
    const held = this.#held;
    this.#held = null;
    this.#past.pause();
    if (held?.what !== "draft") {
      this.cursor = null;
      return this.notify();
    }
    const at = this.cursor;
    if (!isDone || !at) return this.cancel();
    this.set(at.point, REACH / scale);
  }
}
