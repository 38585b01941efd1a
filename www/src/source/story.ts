// Writes the events of a run to its log: goals, how tasks end, exploration, contacts, merged walls,
// loop closures. The same for every source.

import type { Level, LocalisationName, RunStatus, WebRun } from "../protocol/module.js";
import { word } from "../spoken.js";
import { sentence } from "../ui/format.js";

export interface Note {
  time: number;
  level: Level;
  text: string;
  /** Notes with the same topic share one line, which opens to all of them. */
  topic?: string;
  /** Shown at once, not only in the log. */
  alert?: boolean;
}

/** Parts of the reachable area that are worth a line when they become known. */
const MILESTONES = [0.25, 0.5, 0.75, 0.9, 0.95, 0.99];

/** The topic of the result of following a link. */
export const OF_THE_LINK = "link";

/** What is reported when the localisation changes during a run. */
const LOCALISATION: Record<LocalisationName, { level: Level; text: string } | null> = {
  localised: { level: "good", text: "The robot knows where it is" },
  ambiguous: null,
  lost: { level: "warn", text: "The robot is lost: what it sees does not stand where it believes to be" },
};

export class Story {
  #notes: Note[] = [];
  #time = 0;
  #goal = "";
  #end = "";
  #contacts = 0;
  #closures = 0;
  #milestones = 0;
  #misfitNoted = false;
  #wasLocalised = false;
  #fullTold = false;
  #localisation: LocalisationName | null = null;
  #isPlaced = true;
  /** Number of commands so far: the legs of one task share one line. */
  #tasks = 0;

  constructor(private readonly module: WebRun) {}

  take(): Note[] {
    for (const { level, text } of this.module.notices()) this.note(level, text, text);
    return this.#notes.splice(0);
  }

  note(level: Level, text: string, topic?: string): void {
    this.#notes.push({ time: this.#time, level, text, ...(topic === undefined ? {} : { topic }) });
  }

  /** Another task begins. */
  commanded(): void {
    this.#tasks += 1;
  }

  /** Called after each step; `explored` returns the explored fraction, recomputed after a task has
      ended. */
  update(s: RunStatus, explored: (recompute: boolean) => number): void {
    this.#time = s.time;
    if (s.placed !== this.#isPlaced) {
      if (s.placed) this.note("good", "The place of this run in the saved map is proved: they are one map from here on");
      else this.note("warn", "What the robot sees is not where it was left: it maps a piece of its own until its place in the saved map is proved");
      this.#isPlaced = s.placed;
    }
    this.#tellGoal(s);
    const end = s.finished && s.task ? s.task.text : "";
    const ends = end !== "" && end !== this.#end;
    const share = explored(ends);
    const reached = MILESTONES.filter((part) => share >= part);
    if (reached.length > this.#milestones) {
      this.#milestones = reached.length;
      this.note("info", `${Math.round(100 * (reached.at(-1) ?? 0))} % of what can be reached is known, after ${s.distance.toFixed(1)} m`);
    }
    if (s.contacts > this.#contacts) this.note("warn", "Touched something", "contact");
    if (ends && s.task) this.note(s.task.level, sentence(end));
    if (s.loopClosures > this.#closures) this.note("info", "Loop closed: the map was bent back into place", "loop");
    [this.#end, this.#contacts, this.#closures] = [end, s.contacts, s.loopClosures];
  }

  /** Called after each scan. */
  scanned(s: RunStatus): void {
    const merged = this.module.merged();
    for (let i = 0; i + 1 < merged.length; i += 2) {
      this.note("info", `Wall ${merged[i + 1]} turned out to be a part of wall ${merged[i]}: one wall from now on`, "merged");
    }
    // Once localised in the map, a robot that does not fit is lost: the map itself is right.
    this.#wasLocalised ||= s.localisation === "localised";
    if (s.priorMapMisfit && !this.#misfitNoted && !this.#wasLocalised) {
      this.#misfitNoted = true;
      this.tell("warn", `The prior map does not fit: only ${Math.round(100 * s.priorMapOverlap)} % of what the sensor hits is a wall of it. It shows another building or is too rough, or the robot begins elsewhere in it: mend that under Run, Prior map.`);
    }
    if (s.localisation !== this.#localisation) {
      const words = s.localisation && this.#localisation ? LOCALISATION[s.localisation] : null;
      this.#localisation = s.localisation;
      // Each change is a line of its own: "found again" must not hide "lost".
      if (words) this.note(words.level, words.text);
    }
    if (s.mapFull && !this.#fullTold) {
      this.#fullTold = true;
      this.tell("warn", "The map is full: what lies beyond it is left out, and what is in it stays. Save it, or begin again with larger cells (Settings, Map).");
    }
  }

  /** Reports it over the map too. */
  tell(level: Level, text: string, topic?: string): void {
    this.#notes.push({ time: this.#time, level, text, alert: true, ...(topic === undefined ? {} : { topic }) });
  }

  #tellGoal(s: RunStatus): void {
    const goal = Number.isFinite(s.goalX) ? `(${s.goalX.toFixed(2)}, ${s.goalY.toFixed(2)}) m` : "";
    if (goal === this.#goal) return;
    this.#goal = goal;
    if (goal === "" || !s.task) return;
    const where = s.task.planner ? `${goal}, path by ${s.task.planner}` : goal;
    if (s.task.state === "homeward") {
      this.note("info", `All is explored: drives home to ${where}`, `home ${this.#tasks}`);
      return;
    }
    if (s.task.state === "closing") {
      this.note("info", `All is explored: drives on to ${where}, to close the loop`, `loop ${this.#tasks}`);
      return;
    }
    // Exploring replans all the time: that is one line, not a hundred.
    const text = s.mode === "explore" ? `Heads for a frontier at ${where}` : `Goal ${where}`;
    this.note("info", text, `task ${this.#tasks}`);
  }
}

/** What the robot is about to do, in words for a visitor who does not know what a frontier is;
    north is up on the map. */
export function doing({ mode, task, x, y, goalX, goalY }: RunStatus): string {
  if (mode === "manual" || !task) return "";
  if (task.state === "scanning") return "stands and scans";
  if (task.state === "waiting") return task.text;
  if (!Number.isFinite(goalX)) return mode === "explore" ? "looks for a place not seen yet" : "plans a way";
  const [dx, dy] = [goalX - x, goalY - y];
  const wind = WINDS[Math.round(Math.atan2(dy, dx) / (Math.PI / 4) + 8) % 8] ?? "";
  const way = `${Math.hypot(dx, dy).toFixed(1)} m to the ${wind}`;
  if (task.state === "homeward") return `all is explored, drives home, ${way}`;
  if (task.state === "closing") return `all is explored, drives on to close the loop, ${way}`;
  return mode === "explore" ? `heads for a place not seen yet, ${way}` : way;
}

const WINDS = [word("east"), word("north-east"), word("north"), word("north-west"), word("west"), word("south-west"), word("south"), word("south-east")] as const;
