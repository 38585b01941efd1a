// What a simulated and a recorded run have in common: both are SLAM with a pose, a map and a log of what happened.

import type { Known, RunStatus, WebContest, WebExperiment, WebLive, WebReplay } from "../../pkg/slamlab_web.js";
import type { SavedFile, SavedKind } from "../protocol.js";
import type { ContestAsk } from "../protocol/contest.js";
import type { Growth, SigmaCurve } from "../protocol/figures.js";
import type { DiagnosisName, Inspection } from "../protocol/filter.js";
import { type FieldChange, type FieldName, type Frame, LINE, LINE_STRIDE } from "../protocol/frame.js";
import type { Rooms } from "../protocol/rooms.js";
import type { MethodName, SourceKind } from "../protocol/setup.js";
import { Samples, Slow } from "./feeds.js";
import type { Change, Moment, Note, Source } from "./source.js";

/** Cells along one side of a block of the module's grid. */
const BLOCK_CELLS = 64;

/** What a frame tells of SLAM itself. */
type SlamChange = Pick<Frame, "grid" | "gridAnew" | "scan" | "beams" | "found" | "lines" | "known" | "samples">;

export abstract class Run<Module extends WebExperiment | WebReplay | WebLive> implements Source {
  abstract readonly kind: SourceKind;
  readonly title: string;
  readonly method: MethodName;
  time = 0;
  scans = 0;
  finished = false;
  protected readonly module: Module;
  protected readonly knownArea: Slow;
  #body: Float64Array;
  #features = 0;
  #known = { generation: 0, revision: 0, version: -1 };
  /** The grid whose rooms were told last. */
  #roomsOf = { generation: -1, revision: -1 };
  #fieldOf = { generation: -1, revision: -1 };
  #samples = new Samples();
  #notes: Note[] = [];
  #knownSent = false;
  #misfitTold = false;
  #fullTold = false;

  constructor(module: Module, title: string, method: MethodName) {
    this.module = module;
    this.title = title;
    this.method = method;
    this.#body = module.body();
    this.knownArea = new Slow(() => module.known_area());
  }

  /** Scans, and what of a scan was taken in part by part. */
  get version(): number {
    return this.scans;
  }

  abstract step(): void;
  abstract moment(): Moment;
  abstract change(): Change;

  notes(): Note[] {
    return this.#notes.splice(0);
  }

  hash(): string {
    return this.module.state_hash();
  }

  contest({ ground, ends, seconds }: ContestAsk): WebContest {
    return this.module.contest(ground, Float64Array.from(ends), seconds);
  }

  export(what: SavedKind): SavedFile[] {
    const files = this.module.export(what, fileName(this.title));
    const saved = Array.from({ length: files.count() }, (_, i) => ({ name: files.name(i), mime: files.mime(i), bytes: new Uint8Array(files.bytes(i)) }));
    files.free();
    return saved;
  }

  asKnown(): Known {
    return this.module.as_known();
  }

  inspect(matrix: boolean): Inspection | null {
    const inside = this.module.inspect(matrix);
    if (!inside) return null;
    const { robot_rows: robotRows, landmarks, coefficients, sightings, candidates, odometry, gate, new_gate: newGate, max_gap: maxGap } = inside;
    inside.free();
    return { robotRows, landmarks, coefficients, sightings, candidates, odometry, gate, newGate, maxGap };
  }

  rooms(): Rooms | null {
    const found = this.module.rooms(this.#roomsOf.generation, this.#roomsOf.revision);
    if (!found) return null;
    const { regions, doors, corners, rings, generation, revision } = found;
    this.#roomsOf = { generation, revision };
    found.free();
    return { regions, doors, corners, rings };
  }

  forgetRooms(): void {
    this.#roomsOf = { generation: -1, revision: -1 };
  }

  field(name: FieldName): FieldChange | null {
    const before = this.#fieldOf;
    const view = this.module.field(name, before.generation, before.revision);
    const { generation, revision, resolution, step, blocks, cells } = view;
    view.free();
    this.#fieldOf = { generation, revision };
    const anew = generation !== before.generation;
    return blocks.length === 0 && !anew ? null : { name, anew, step, resolution, blockCells: BLOCK_CELLS, index: blocks, cells };
  }

  forgetField(): void {
    this.#fieldOf = { generation: -1, revision: -1 };
  }

  abstract estimateSigma(growth: Growth): SigmaCurve;

  close(): void {
    this.module.free();
  }

  protected note(level: Note["level"], text: string, topic?: string): void {
    this.#notes.push({ time: this.time, level, text, ...(topic === undefined ? {} : { topic }) });
  }

  /** Says once that what is seen is not what the known map shows. */
  #tellMisfit(s: RunStatus): void {
    if (!s.known_misfit || this.#misfitTold) return;
    this.#misfitTold = true;
    const text = `The known map does not fit: only ${Math.round(100 * s.known_part)} % of what the sensor hits is a wall of it. It shows another building or is too rough, or the robot begins elsewhere in it: mend that under Run, Known map.`;
    this.#notes.push({ time: this.time, level: "warn", text, alert: true });
  }

  /** Says once that the map could not grow any further. */
  #tellFull(s: RunStatus): void {
    if (!s.map_full || this.#fullTold) return;
    this.#fullTold = true;
    const text = "The map is full: what lies beyond it is left out, and what is in it stays. Save it, or begin again with larger cells (Settings, Map).";
    this.#notes.push({ time: this.time, level: "warn", text, alert: true });
  }

  /** Reads the numbers of the moment. */
  protected read<T>(use: (status: RunStatus) => T): T {
    const status = this.module.status();
    try {
      return use(status);
    } finally {
      status.free();
    }
  }

  /** Keeps what the plots need of the scan just taken in. */
  protected sample(s: RunStatus, scanMillis: number, explored: number): void {
    this.#tellMisfit(s);
    this.#tellFull(s);
    const merged = this.module.merged();
    for (let i = 0; i + 1 < merged.length; i += 2) {
      this.note("info", `Wall ${merged[i + 1]} turned out to be a part of wall ${merged[i]}: one wall from now on`, "merged");
    }
    this.#samples.add({
      time: s.time,
      positionError: Math.hypot(s.x - s.truth_x, s.y - s.truth_y),
      positionSigma3: 3 * Math.sqrt(largestVariance(s.cov_xx, s.cov_xy, s.cov_yy)),
      headingError: Math.abs(degrees(turnBetween(s.heading, s.truth_heading))),
      headingSigma3: degrees(3 * Math.sqrt(Math.max(0, s.cov_heading))),
      scanMillis,
      explored,
      nees: s.nees, neesLow: s.nees_low, neesHigh: s.nees_high,
      nis: s.nis, nisLow: s.nis_low, nisHigh: s.nis_high,
    });
  }

  /** The numbers that every source has. */
  protected momentOf(s: RunStatus): Omit<Moment, "source" | "mode" | "reason" | "activity" | "explored" | "beamHalfAngle"> {
    const [halfLength = 0.1, halfWidth = 0.1, isRectangle = 0] = this.#body;
    return {
      diagnosis: this.module.diagnosis() as DiagnosisName,
      time: s.time, scans: s.scans, progress: s.progress, finished: this.finished,
      goalX: s.goal_x, goalY: s.goal_y,
      x: s.x, y: s.y, heading: s.heading,
      covXx: s.cov_xx, covXy: s.cov_xy, covYy: s.cov_yy, covHeading: s.cov_heading,
      truthX: s.truth_x, truthY: s.truth_y, truthHeading: s.truth_heading,
      odometryX: s.odometry_x, odometryY: s.odometry_y, odometryHeading: s.odometry_heading,
      positionError: Math.hypot(s.x - s.truth_x, s.y - s.truth_y), headingError: turnBetween(s.heading, s.truth_heading),
      odometryError: Math.hypot(s.odometry_x - s.truth_x, s.odometry_y - s.truth_y),
      knownPart: s.known_part, knownMisfit: s.known_misfit, knownArea: this.knownArea.value, features: this.#features,
      distance: s.distance, contacts: s.contacts, halfLength, halfWidth, isRectangle: isRectangle === 1,
    };
  }

  /** What SLAM changed; scan and lines only where a scan came since. */
  protected slamChange(): SlamChange {
    const { generation, revision, version } = this.#known;
    const view = this.module.view(generation, revision);
    const { blocks, cells, resolution } = view;
    this.#known = { generation: view.generation, revision: view.revision, version: this.version };
    const scanned = version !== this.version;
    const lines = (scanned && view.lines) || null;
    if (lines) this.#features = countWalls(lines);
    const known = this.#knownSent ? null : this.module.known_walls();
    this.#knownSent = true;
    const change = {
      known,
      grid: blocks.length === 0 ? null : { resolution, blockCells: BLOCK_CELLS, index: blocks, cells },
      gridAnew: view.generation !== generation,
      scan: scanned ? view.scan : null,
      beams: scanned ? view.beams : null,
      found: scanned ? view.found : null,
      lines,
      samples: this.#samples.take(),
    };
    view.free();
    return change;
  }
}

function fileName(title: string): string {
  return title.replace(/\.[a-z]+$/i, "").replace(/[^\w-]+/g, "-");
}

/** Variance along the most uncertain direction of a 2 x 2 covariance. */
function largestVariance(xx: number, xy: number, yy: number): number {
  return Math.max(0, (xx + yy) / 2 + Math.hypot((xx - yy) / 2, xy));
}

function countWalls(lines: Float64Array): number {
  let count = 0;
  for (let i = LINE.confirmed; i < lines.length; i += LINE_STRIDE) count += lines[i] ? 1 : 0;
  return count;
}

function degrees(radians: number): number {
  return (radians * 180) / Math.PI;
}

/** From `b` to `a`, in (-π, π]. */
function turnBetween(a: number, b: number): number {
  return Math.atan2(Math.sin(a - b), Math.cos(a - b));
}
