// Requests besides the run itself: settings, calibration, σ(ρ), the fit of a drive, the judgement
// of the map, a trial of the controller, planners, maps, pose graphs, files to save.

import { calibrate, read_preset, write_preset } from "../../pkg/slamlab_web.js";
import { attempt, fail, post } from "../answer.js";
import type { Command, GivenBytes, Handlers } from "../protocol.js";
import type { DriveFit, GivenFile, SavedFile } from "../protocol/module.js";
import { ContestRunner } from "./contest.js";
import { fileModule } from "./file_module.js";
import type { FileModule } from "./files.js";
import type { GoingOn } from "./going_on.js";
import type { Player } from "./player.js";

type Questions = Pick<Handlers<Command>, "examine" | "settings" | "calibrate" | "sigma" | "fit" | "quality" | "preset" | "bench" | "save" | "collect" | "save-submap" | "build" | "read-prior-map" | "solve-graph" | "world-file" | "check-world" | "contest" | "contest-watch" | "contest-stop">;

export function questions(player: Player, savedMap: GoingOn): Questions {
  const contest = new ContestRunner();
  /** The last fit. */
  let fitted: DriveFit | null = null;
  player.onBegin = () => contest.close();

  const filesOf = (what: Parameters<Questions["save"]>[0]["what"]): SavedFile[] =>
    what === "saved-map" ? savedMap.files() : player.run ? presetFile(player.run.title, fitted) : [];

  return {
    examine: ({ number, x, y, wall = false, beam, leaf }) => {
      const { run } = player;
      if (!run) return;
      const { module, time } = run;
      post({
        kind: "examined", run: player.number, number, time, cell: module.cell(x, y), inspection: wall ? module.inspect(false) ?? null : null,
        beam: beam === undefined ? null : module.beam(beam) ?? null, leaf: leaf === undefined ? null : module.leaf(Float64Array.from(leaf)) ?? null,
      });
    },
    settings: ({ settings }) => {
      const { run } = player;
      if (run) post({ kind: "settings", settings: run.module.settings(settings) });
    },
    calibrate: ({ pairs }) => post({ kind: "calibrated", ...attempt("calibration", () => calibrate(pairs)) }),
    sigma: ({ growth }) => {
      const { run } = player;
      if (run) post({ kind: "sigma", ...attempt("curve", () => run.module.estimate_sigma(growth)) });
    },
    fit: () => {
      fitted = player.run?.module.fit() ?? null;
      if (fitted) post({ kind: "fit", fit: fitted, error: "" });
    },
    quality: () => player.judge(),
    preset: ({ name, bytes }) => given(name, () => post({ kind: "preset", ...read_preset(new Uint8Array(bytes)) })),
    bench: ({ trial }) => {
      if (player.run?.kind === "sim") post({ kind: "bench", response: player.run.module.bench(trial) });
    },
    save: ({ what }) => given("", () => post({ kind: "saved", files: filesOf(what) })),
    collect: ({ what }) => {
      const { run } = player;
      const { files, error } = attempt("files", () => run?.module.export(what, fileName(run.title)) ?? []);
      post({ kind: "collected", files: files ?? [], error });
    },
    "save-submap": ({ submap }) => given("", () => {
      const { run } = player;
      if (run) post({ kind: "saved", files: [run.module.submap_file(submap, fileName(run.title))] });
    }),
    build: ({ name, files }) => void givenFile(name, ({ read_building }) => post({ kind: "built", name, ...read_building(name, files.map(fileOf)) })),
    "read-prior-map": ({ name, files }) => {
      if (files.length > 0) return void givenFile(name, ({ read_prior_map }) => post({ kind: "prior-map", ...read_prior_map(name, files.map(fileOf)) }));
      given(name, () => {
        const map = player.run?.module.as_prior_map(name);
        if (map) post({ kind: "prior-map", ...map });
      });
    },
    "solve-graph": ({ name, bytes }) => void givenFile(name, ({ solve_graph }) => {
      const graph = solve_graph(new Uint8Array(bytes));
      post({ kind: "solved-graph", name, graph }, [graph.before, graph.after, graph.file].map(({ buffer }) => buffer as ArrayBuffer));
    }),
    "world-file": ({ world }) => void givenFile("", ({ world_file }) => post({ kind: "world-file", world, text: world_file(world) })),
    "check-world": ({ text, number }) => void givenFile("", ({ check_world }) => post({ kind: "world-checked", number, ...check_world(text) })),
    contest: ({ ask, watched }) => {
      const { run } = player;
      if (run) contest.begin(watched, () => run.module.contest(ask));
    },
    "contest-watch": ({ watched }) => contest.watch(watched),
    "contest-stop": () => contest.stop(),
  };
}

/** Does work on given data. If the data cannot be used, their name precedes the reason. */
export function given(name: string, work: () => void): void {
  try {
    work();
  } catch (error) {
    fail(error, name);
  }
}

/** The same with a foreign file, whose module may have to be loaded first. */
async function givenFile(name: string, work: (module: FileModule) => void): Promise<void> {
  try {
    work(await fileModule());
  } catch (error) {
    fail(error, name);
  }
}

function fileOf({ name, bytes }: GivenBytes): GivenFile {
  return { name, bytes: new Uint8Array(bytes) };
}

function fileName(title: string): string {
  return title.replace(/\.[a-z]+$/i, "").replace(/[^\w-]+/g, "-");
}

/** The last fit, as a preset. */
function presetFile(title: string, fitted: DriveFit | null): SavedFile[] {
  if (!fitted) throw new Error("Nothing was fitted yet.");
  const text = write_preset(`fit of ${title}`, fitted);
  return [{ name: `${title.replace(/[^\w-]+/g, "-")}-preset.json`, mime: "application/json", bytes: new TextEncoder().encode(text) }];
}
