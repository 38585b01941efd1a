// The state of the registration lab, and its end of the connection to the worker. Components read
// and call it; all computing is done in the worker.

import { handle, type Handlers } from "../protocol.js";
import { BASIN, BASIN_STRIDE, type BasinAxesName, ITERATION, ITERATION_STRIDE, type RegistrationAdvice, type RegistrationOffer } from "../protocol/module.js";
import { t } from "../words.js";
import { between, middle, NOWHERE, place, turned } from "./pose.js";
import type { Found, LabAnswer, LabCommand, Pose, Role } from "./protocol.js";

/** Two clouds, each in its own frame, m. */
export interface Clouds {
  readonly title: string;
  readonly fixed: Float64Array;
  readonly moving: Float64Array;
  /** The pose of the moving cloud in the fixed one's frame, if known, and from whom. */
  readonly truth: Pose | null;
  readonly truthWords: string;
  /** Whether a sensor stood at the origin of each. */
  readonly areScans: boolean;
}

export interface BasinMap {
  readonly method: string;
  readonly axes: BasinAxesName;
  readonly cells: number;
  readonly shift: number;
  readonly turn: number;
  readonly right: Pose;
  /** The outcome and the error of each cell; NaN if not computed yet. */
  readonly outcomes: Float32Array;
  readonly errors: Float32Array;
  readonly progress: number;
  readonly state: "running" | "done" | "cancelled";
}

/** Clouds with more points than this are thinned, to keep dragging smooth. */
export const MOST_POINTS = 2000;
/** Milliseconds per iteration while it plays. */
const PLAY_MILLIS = 220;
/** The farthest starts in a map of starts, m and rad. */
export const REACH = { shift: 2, turn: Math.PI / 2 } as const;
const EMPTY = new Float64Array(0);

export class LabModel {
  offer: RegistrationOffer | null = null;
  clouds: Clouds = { title: "", fixed: EMPTY, moving: EMPTY, truth: null, truthWords: "", areScans: true };
  /** The name of the built-in pair that is shown. */
  pair = "";
  start: Pose = NOWHERE;
  /** Methods that are run. */
  shown: ReadonlySet<string> = new Set();
  found: readonly Found[] = [];
  advice: RegistrationAdvice | null = null;
  right: Pose | null = null;
  /** The iteration that is shown; one past the last is the end. */
  step = 0;
  playing = false;
  correspondences: ReadonlyMap<string, Float32Array> = new Map();
  basin: BasinMap | null = null;
  /** The cloud that is being drawn by hand. */
  pen: Role | null = null;
  error = "";
  note = "";
  /** Whether the worker is running the methods. */
  running = false;

  readonly #worker = new Worker(new URL("registration_worker.js", import.meta.url), { type: "module", name: "registration" });
  readonly #listeners = new Set<() => void>();
  /** Whether the start changed during a run, so that another run has to follow. */
  #isStale = false;
  #isLooking = false;
  #wished: number | null = null;
  /** Whether the last step stays shown while clouds are dragged. */
  #atEnd = true;
  #player: ReturnType<typeof setInterval> | null = null;

  constructor() {
    this.#worker.onmessage = (event: MessageEvent<LabAnswer>) => handle(this.#handlers, event.data);
    this.#worker.onerror = (event) => this.#change({ error: t`The lab stopped: ${event.message || "its worker could not be started"}. Reload the page.` });
  }

  on(listener: () => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  /** Chooses a built-in pair. */
  choose(name: string): void {
    this.#send({ kind: "pair", name });
  }

  open(file: File, role: Role): void {
    void file.arrayBuffer().then((bytes) => this.#send({ kind: "file", name: file.name, bytes, role }, [bytes]), () => this.#change({ error: t`${file.name} cannot be read.` }));
  }

  /** Sets other clouds; the moving one begins at `start`. */
  setClouds(clouds: Clouds, start: Pose): void {
    const [fixed, moving] = [thinned(clouds.fixed), thinned(clouds.moving)];
    const dropped = (clouds.fixed.length + clouds.moving.length - fixed.length - moving.length) / 2;
    const note = dropped > 0 ? t`Of each cloud at most ${MOST_POINTS} points are used: ${dropped} were left out, evenly.` : "";
    this.#change({ clouds: { ...clouds, fixed, moving }, start, found: [], advice: null, right: null, step: 0, basin: null, correspondences: new Map(), error: "", note });
    this.#send({ kind: "clouds", fixed, moving, areScans: clouds.areScans });
    this.#atEnd = true;
    this.run();
  }

  move(start: Pose): void {
    this.#change({ start });
    this.run();
  }

  /** Turns the moving cloud about its middle. */
  turn(by: number): void {
    this.move(turned(this.start, by, place(this.start, ...middle(this.clouds.moving))));
  }

  toggle(method: string): void {
    const shown = new Set(this.shown);
    if (!shown.delete(method)) shown.add(method);
    this.#change({ shown });
    this.run();
  }

  /** Runs the chosen methods from the present start: at once, or after the present run. */
  run(): void {
    const { fixed, moving, truth } = this.clouds;
    if (fixed.length === 0 || moving.length === 0 || this.shown.size === 0) return this.#change({ found: [], advice: null, correspondences: new Map() });
    this.#isStale = this.running;
    if (this.running) return;
    this.#change({ running: true });
    this.#send({ kind: "register", start: this.start, methods: this.methods, truth });
  }

  /** The methods that are run, in the order of the core. */
  get methods(): string[] {
    return (this.offer?.methods ?? []).filter((name) => this.shown.has(name));
  }

  /** The step after the last iteration of the longest run. */
  get lastStep(): number {
    return Math.max(0, ...this.found.map(iterations));
  }

  show(step: number): void {
    this.#atEnd = step >= this.lastStep;
    this.#change({ step: Math.min(Math.max(step, 0), this.lastStep) });
    this.#look();
  }

  play(on: boolean): void {
    if (this.#player) clearInterval(this.#player);
    this.#player = null;
    this.#change({ playing: on });
    if (!on) return;
    if (this.step >= this.lastStep) this.show(0);
    this.#player = setInterval(() => {
      if (this.step >= this.lastStep) this.play(false);
      else this.show(this.step + 1);
    }, PLAY_MILLIS);
  }

  /** Fills a map of starts around the right pose. */
  fill(method: string, axes: BasinAxesName, cells: number): void {
    const { right } = this;
    if (!right) return;
    const count = cells * cells;
    this.#change({ basin: { method, axes, cells, ...REACH, right, outcomes: new Float32Array(count).fill(NaN), errors: new Float32Array(count).fill(NaN), progress: 0, state: "running" } });
    this.#send({ kind: "basin", ask: { method, right: [...right], axes, ...REACH, cells } });
  }

  cancelFill(): void {
    if (this.basin?.state !== "running") return;
    this.#send({ kind: "basin-stop" });
    this.#change({ basin: { ...this.basin, state: "cancelled" } });
  }

  setPen(pen: Role | null): void {
    this.#change({ pen });
  }

  /** The lab is closed: stops all work. */
  rest(): void {
    this.play(false);
    this.cancelFill();
  }

  say(error: string): void {
    this.#change({ error });
  }

  #look(): void {
    if (this.#isLooking) {
      this.#wished = this.step;
      return;
    }
    this.#isLooking = true;
    this.#send({ kind: "look", methods: this.found.map(({ method }) => method), iteration: this.step });
  }

  #send(command: LabCommand, transfer: Transferable[] = []): void {
    this.#worker.postMessage(command, transfer);
  }

  #change(patch: Partial<LabModel>): void {
    Object.assign(this, patch);
    for (const listener of this.#listeners) listener();
  }

  readonly #handlers: Handlers<LabAnswer> = {
    ready: ({ offer }) => {
      this.#change({ offer, shown: new Set(offer.methods) });
      const first = offer.pairs[0];
      if (first && this.clouds.fixed.length === 0) this.choose(first.name);
    },
    pair: ({ name, pair }) => {
      const title = this.offer?.pairs.find((each) => each.name === name)?.title ?? name;
      this.#change({ pair: name, pen: null });
      this.setClouds({ title, fixed: pair.fixed, moving: pair.moving, truth: pair.truth, truthWords: "the simulator knows it", areScans: true }, NOWHERE);
    },
    file: ({ name, role, points }) => {
      // If the other cloud is from a file it stays, otherwise it is dropped.
      const isNext = this.pair === "files";
      const kept = isNext ? this.clouds : { ...this.clouds, fixed: EMPTY, moving: EMPTY };
      this.#change({ pair: "files", pen: null });
      this.setClouds({ ...kept, title: name, [role]: points, truth: null, truthWords: "", areScans: isNext ? this.clouds.areScans : true }, NOWHERE);
    },
    registered: ({ found, advice, right }) => {
      this.#change({ found, advice, right, running: false });
      const last = this.lastStep;
      this.#change({ step: this.#atEnd ? last : Math.min(this.step, last) });
      this.#look();
      if (this.#isStale) this.run();
    },
    looked: ({ methods, rows }) => {
      this.#isLooking = false;
      this.#change({ correspondences: new Map(methods.map((method, i) => [method, rows[i] ?? new Float32Array(0)])) });
      if (this.#wished === null) return;
      this.#wished = null;
      this.#look();
    },
    basin: ({ cells, progress, isOver }) => {
      const { basin } = this;
      if (basin?.state !== "running") return;
      for (let i = 0; i + BASIN_STRIDE <= cells.length; i += BASIN_STRIDE) {
        const index = cells[i + BASIN.index] ?? 0;
        basin.outcomes[index] = cells[i + BASIN.outcome] ?? NaN;
        basin.errors[index] = cells[i + BASIN.error] ?? NaN;
      }
      this.#change({ basin: { ...basin, progress, state: isOver ? "done" : "running" } });
    },
    failed: ({ text }) => this.#change({ error: text, running: false }),
  };
}

/** Number of recorded iterations. */
export function iterations({ steps }: Found): number {
  return steps.length / ITERATION_STRIDE;
}

/** The moving cloud's pose at a step of a run; after its last iteration, the final pose. */
export function poseAt(found: Found, step: number): Pose {
  if (step >= iterations(found)) return found.pose;
  const at = (field: number): number => found.steps[step * ITERATION_STRIDE + field] ?? 0;
  return [at(ITERATION.x), at(ITERATION.y), at(ITERATION.heading)];
}

/** A figure of an iteration; after the end of the run, that of the last one. */
export function figureAt(found: Found, step: number, field: "width" | "residual" | "matched"): number {
  const row = Math.min(step, iterations(found) - 1);
  return found.steps[row * ITERATION_STRIDE + ITERATION[field]] ?? NaN;
}

/** Distance and turn of a pose from the right one. */
export function errorOf(pose: Pose, right: Pose): { shift: number; turn: number } {
  const [x, y, turn] = between(right, pose);
  return { shift: Math.hypot(x, y), turn: Math.abs(turn) };
}

/** Thinned evenly to a number of points that can be dragged smoothly. */
function thinned(points: Float64Array): Float64Array {
  const every = Math.ceil(points.length / 2 / MOST_POINTS);
  return every <= 1 ? points : points.filter((_, i) => Math.floor(i / 2) % every === 0);
}
