// Registers clouds for the lab, in a worker of its own, so that a map of starts does not delay a
// run.

import init, { builtin_pair, read_point_list, registration_offer, type WebBasin, WebClouds } from "../../pkg/slamlab_lab.js";
import { faultOf } from "../fault.js";
import { handle, type Handlers } from "../protocol.js";
import { Turns } from "../turns.js";
import type { Found, LabAnswer, LabCommand, Pose } from "./protocol.js";

/** Wall milliseconds of one slice of a map of starts, and between two reports. */
const SLICE_MILLIS = 12;
const REPORT_MILLIS = 80;

const post = (answer: LabAnswer, transfer: Transferable[] = []): void => {
  (self as unknown as { postMessage(message: LabAnswer, transfer: Transferable[]): void }).postMessage(answer, transfer);
};

let clouds: WebClouds | null = null;

/** A map of starts, computed in slices; commands are handled between them. */
class BasinRunner {
  readonly #turns = new Turns(() => guard(() => this.#turn()));
  #basin: WebBasin | null = null;
  #cells: number[] = [];
  #reportAt = -Infinity;

  begin(basin: WebBasin): void {
    this.stop();
    this.#basin = basin;
    this.#cells = [];
    this.#reportAt = -Infinity;
    this.#turns.wake();
  }

  stop(): void {
    this.#basin?.free();
    this.#basin = null;
  }

  #turn(): void {
    const basin = this.#basin;
    if (!basin) return;
    const begin = performance.now();
    let isOver = false;
    while (!isOver && performance.now() - begin < SLICE_MILLIS) {
      const row = basin.step();
      isOver = row.length === 0;
      this.#cells.push(...row);
    }
    if (isOver || begin - this.#reportAt >= REPORT_MILLIS) {
      this.#reportAt = begin;
      const cells = new Float32Array(this.#cells);
      this.#cells = [];
      post({ kind: "basin", cells, progress: basin.progress(), isOver }, [cells.buffer]);
    }
    if (isOver) this.stop();
    else this.#turns.wake();
  }
}

const basins = new BasinRunner();

/** The reference pose: the truth, or else that of the best verdict. */
function rightOf(found: readonly Found[], truth: Pose | null): Pose | null {
  if (truth) return truth;
  const sure = found.filter(({ verdict }) => verdict === "converged" || verdict === "degenerate");
  const best = sure.sort((a, b) => Number(b.verdict === "converged") - Number(a.verdict === "converged") || b.overlap - a.overlap)[0];
  return best ? best.pose : null;
}

const handlers: Handlers<LabCommand> = {
  pair: ({ name }) => post({ kind: "pair", name, pair: builtin_pair(name) }),
  file: ({ name, bytes, role }) => {
    try {
      post({ kind: "file", name, role, points: read_point_list(new Uint8Array(bytes)) });
    } catch (error) {
      post({ kind: "failed", text: `${name}: ${faultOf(error).text}` });
    }
  },
  clouds: ({ fixed, moving, areScans }) => {
    basins.stop();
    const made = new WebClouds(moving, fixed, areScans);
    clouds?.free();
    clouds = made;
  },
  register: ({ start, methods, truth }) => {
    const subject = clouds;
    if (!subject) return;
    const from = new Float64Array(start);
    const found = methods.map((method) => {
      const begin = performance.now();
      const registered = subject.register(method, from);
      return { ...registered, method, millis: performance.now() - begin };
    });
    const right = rightOf(found, truth);
    const advice = right ? subject.advise(new Float64Array(right), from) ?? null : null;
    post({ kind: "registered", found, advice, right });
  },
  look: ({ methods, iteration }) => {
    const subject = clouds;
    if (!subject) return;
    const rows = methods.map((method) => subject.correspondences(method, iteration));
    post({ kind: "looked", iteration, methods, rows }, rows.map((each) => each.buffer as ArrayBuffer));
  },
  basin: ({ ask }) => {
    if (clouds) basins.begin(clouds.basin(ask));
  },
  "basin-stop": () => basins.stop(),
};

function guard(act: () => void): void {
  try {
    act();
  } catch (error) {
    const { about, text } = faultOf(error);
    if (about === "internal") console.error(error);
    post({ kind: "failed", text });
  }
}

const module = init({ module_or_path: new URL("slamlab_lab_bg.wasm", self.location.href) });

self.onmessage = async (event: MessageEvent<LabCommand>) => {
  await module.catch(() => null);
  guard(() => handle(handlers, event.data));
};

module.then(() => guard(() => post({ kind: "ready", offer: registration_offer() })), (error: unknown) => {
  post({ kind: "failed", text: `The lab could not be loaded: ${faultOf(error).text}. Reload the page.` });
});
