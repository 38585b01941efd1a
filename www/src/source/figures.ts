// What is asked of a run beside the run: settings, calibration, σ(ρ), the fit of a drive, a trial of the controller, files to save.

import { type FitTable, calibrate, read_preset, setting_list, write_preset } from "../../pkg/slamlab_web.js";
import { attempt, post, refuse } from "../answer.js";
import type { Command, SavedFile } from "../protocol.js";
import { BridgeSource } from "./bridge.js";
import { calibrationOf, driveFit, listOf, settingOf } from "./convert.js";
import { ReplaySource } from "./replay.js";
import { SimSource } from "./sim.js";
import type { Source } from "./source.js";

type Asked = Extract<Command, { kind: "settings" | "calibrate" | "sigma" | "fit" | "preset" | "bench" | "save" }>;

/** The fit that was asked for last. */
let fitted: FitTable | null = null;

/** Answers, if there is a source that can. */
export function answerOf(command: Asked, source: Source | null): void {
  switch (command.kind) {
    case "settings":
      post({ kind: "settings", settings: setting_list(command.source, command.method, command.sensor, ...listOf(command.settings)).map(settingOf) });
      break;
    case "calibrate":
      post({ kind: "calibrated", ...attempt("calibration", () => calibrationOf(calibrate(command.pairs.text, command.pairs.variable))) });
      break;
    case "sigma":
      if (source) post({ kind: "sigma", ...attempt("curve", () => source?.estimateSigma(command.growth) ?? null) });
      break;
    case "fit":
      if (source instanceof ReplaySource || source instanceof BridgeSource) {
        fitted?.free();
        fitted = source.fit();
        post({ kind: "fit", fit: driveFit(fitted), error: "" });
      }
      break;
    case "preset":
      try {
        const { name, keys, values } = read_preset(new Uint8Array(command.bytes));
        // Keys and ranges are looked at before anything takes them.
        for (const setting of setting_list("sim", "line-ekf", "lidar", keys, values)) setting.free();
        post({ kind: "preset", name, settings: Object.fromEntries(keys.map((key, i) => [key, values[i] ?? NaN])) });
      } catch (error) {
        refuse(command.name, error);
      }
      break;
    case "bench":
      if (source instanceof SimSource) post({ kind: "bench", response: source.bench(command.trial) });
      break;
    case "save":
      if (!source) break;
      try {
        post({ kind: "saved", files: command.what === "fit" ? presetFile(source) : source.export(command.what) });
      } catch (error) {
        refuse("", error);
      }
      break;
  }
}

/** What was fitted last, as a preset. */
function presetFile({ title }: Source): SavedFile[] {
  if (!fitted) throw new Error("Nothing was fitted yet.");
  const text = write_preset(`fit of ${title}`, fitted);
  return [{ name: `${title.replace(/[^\w-]+/g, "-")}-preset.json`, mime: "application/json", bytes: new TextEncoder().encode(text) }];
}
