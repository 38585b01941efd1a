// Buildings and maps that somebody gave, and what a run starts from, between protocol and module.

import { BuildingFiles, Known, WebSetup } from "../../pkg/slamlab_web.js";
import { post } from "../answer.js";
import type { GivenFile, KnownMap, Setup } from "../protocol/setup.js";
import { BridgeSource } from "./bridge.js";
import { listOf } from "./convert.js";
import type { Source } from "./source.js";

function buildingOf<T>(files: readonly GivenFile[], use: (building: BuildingFiles) => T): T {
  const building = new BuildingFiles();
  try {
    for (const { name, bytes } of files) building.add(name, new Uint8Array(bytes));
    return use(building);
  } finally {
    building.free();
  }
}

/** A building to drive in, for the page to begin in. */
export function build(name: string, files: readonly GivenFile[]): void {
  const building = buildingOf(files, (given) => given.world(name));
  const { world: worldJson, left_out: leftOut } = building;
  building.free();
  post({ kind: "built", name, worldJson, leftOut });
}

/** A map to be found in: from files, or without any as the source has drawn it. */
export function know(name: string, files: readonly GivenFile[], source: Source | null): void {
  const map = files.length > 0 ? buildingOf(files, (given) => given.known()) : source?.asKnown();
  if (!map) return;
  const { faces, sigma, left_out: leftOut } = map;
  let [x = 0, y = 0, heading = 0] = map.start;
  map.free();
  // A real robot is not put back to where the map began.
  if (files.length === 0 && source instanceof BridgeSource) ({ x, y, heading } = source.moment());
  post({ kind: "known", known: { name, faces, sigma, start: [x, y, heading] }, leftOut });
}

export function knownOf({ faces, sigma, start }: KnownMap): Known {
  return new Known(faces, sigma, Float64Array.from(start));
}

export function setupOf(setup: Setup): WebSetup {
  const web = new WebSetup();
  const [keys, values] = listOf(setup.settings);
  return Object.assign(web, {
    world: setup.worldJson ?? setup.world, is_file: setup.worldJson !== null, sensor: setup.sensor, seed: setup.seed, method: setup.method, mode: setup.mode,
    cycle: setup.cycle, keys, values, calibration: setup.calibration?.text ?? "", variable: setup.calibration?.variable ?? "",
    known: setup.known ? knownOf(setup.known) : undefined,
  });
}
