// The texts that the core shows to people: its tables, from the module, and the sentences that it
// puts together, from its sources: about a run, and about errors in a file, a setting, a link or a
// device. So each text is written in one place, and the command line shows it in English.

import { readFileSync } from "node:fs";
import { initSync as initLab, registration_offer } from "./pkg/slamlab_lab.js";
import { initSync, offer, WebRun } from "./pkg/slamlab_web.js";

const here = new URL("./", import.meta.url);
const at = (path) => new URL(path, here);

/** Sources whose sentences a run shows as it goes on. */
const SOURCES = [
  "core/src/pilot/status.rs", "core/src/pilot/stages.rs", "core/src/plan/path.rs", "core/src/plan/rooms.rs",
  "core/src/settings/applies.rs", "core/src/slam.rs", "core/src/live/homing.rs",
  "core/src/estimation/map_alignment.rs", "core/src/estimation/odometry_fit/words.rs", "core/src/estimation/drive_fit.rs",
  "core/src/estimation/scan_matching/removal.rs", "core/src/estimation/scan_matching/merging.rs",
  "web/src/run.rs", "web/src/export.rs", "web/src/contest.rs",
];
/** Sources whose sentences say why a file, a link or a device cannot be used. */
const REFUSALS = [
  "core/src/format/known_file.rs", "core/src/replay/reader.rs", "core/src/format/field_error.rs", "core/src/format/text_log.rs",
  "core/src/format/carmen/error.rs", "core/src/format/world.rs", "core/src/format/slamlab.rs", "core/src/format/building/file.rs",
  "core/src/format/building/error.rs", "core/src/format/map_server/error.rs", "core/src/experiment/link.rs", "core/src/device/rplidar/fault.rs",
  "core/src/format/poses.rs", "core/src/replay/pose_track.rs", "core/src/replay/posed_log.rs", "core/src/replay/truth.rs",
  "core/src/format/g2o.rs", "core/src/format/g2o/graph.rs", "core/src/format/smap.rs", "core/src/format/smap/read.rs", "core/src/format/map_points.rs",
  "core/src/format/calibration.rs", "core/src/format/preset.rs", "core/src/format/point_list.rs", "core/src/format/og_map.rs",
  "core/src/format/ros/mod.rs", "core/src/replay/ros.rs", "core/src/replay/ros/choice.rs", "core/src/replay/ros/clock.rs",
  "core/src/replay/ros/motion.rs", "core/src/replay/ros/scans.rs", "core/src/settings.rs",
  "core/src/format/ros/fields.rs", "core/src/format/ros/unpack.rs", "core/src/format/floor_plan.rs",
  "core/src/sim/world/check.rs", "core/src/sim/simulation.rs", "core/src/sim/doors.rs", "core/src/geom/geofence.rs",
  "core/src/robot/scan.rs", "core/src/estimation/scan_matching/edits.rs", "core/src/wire/recording/error.rs", "core/src/replay.rs", "core/src/lesson.rs",
  "web/src/link.rs", "web/src/setup.rs", "web/src/recording.rs",
];
/** Words that are inserted into these sentences. */
const IN_PLACES = ["no error is told of them", "left", "right", "more than 0", "a script", "a newer"];
/** Strings that are no text of ours: beginnings of files, texts of others, and lists. */
const NO_SENTENCE = /^<[!a-z]|^-----|^version https|^expected (f64|u32|u64|an array of length 2)$|^\{0\} at line \{1\} column|^\{0\}, \{1\}$|^\{0\} of <\{1\}>$/;

export function saidByCore() {
  initSync({ module: readFileSync(at("pkg/slamlab_web_bg.wasm")) });
  const { sensors, methods, devices, presets, lessons } = offer();
  const run = WebRun.simulate({ ...lessons[0].setup, lesson: null });
  const settings = run.settings({});
  run.free();
  initLab({ module: readFileSync(at("pkg/slamlab_lab_bg.wasm")) });
  const { pairs, measured } = registration_offer();
  const texts = [
    ...pairs.map(({ title }) => title),
    ...measured.map(({ title }) => title),
    ...sensors.map(({ title }) => title),
    ...methods.flatMap(({ title, meaning }) => [title, meaning]),
    ...devices.map(({ about }) => about),
    ...presets.flatMap(({ group, name, meaning }) => [group, name, meaning]),
    ...lessons.flatMap(({ title, fault, task, hint }) => [title, fault, task, hint]),
    ...settings.flatMap(({ group, name, meaning, choices }) => [group, name, meaning, ...choices]),
    ...IN_PLACES,
  ];
  return texts.filter((text) => /\p{L}{2}/u.test(text));
}

export function heardFromCore() {
  const read = (file) => sentencesOf(readFileSync(at(`../${file}`), "utf8"));
  return [...SOURCES.flatMap(read), ...REFUSALS.flatMap(read).filter((text) => !NO_SENTENCE.test(text))];
}

/** The sentences of a Rust source: {0}, {1} … where it has arguments, whatever their names. */
function sentencesOf(source) {
  const code = source.replace(/#\[cfg\(test\)\][\s\S]*$/, "").replace(/^\s*\/\/.*$/gm, "").replace(/#!?\[(expect|allow|doc)[\s\S]*?\)\]/g, "");
  // Byte strings are the beginnings of files.
  const strings = [...code.matchAll(/(b?)"((?:[^"\\]|\\[\s\S])*)"/g)].filter(([, bytes]) => bytes === "");
  const literals = strings.map(([, , text]) => text.replace(/\\\n\s*/g, "").replaceAll('\\"', '"'));
  return literals.filter((text) => /\p{L}{2}.* |^(; |, )|: $|^ of \{/u.test(text) && !/_/.test(text.replace(/\{[^}]*\}/g, ""))).map(numbered);
}

function numbered(text) {
  let next = 0;
  const places = text.replace(/\{[^{}]*\}/g, () => `{${next++}}`);
  const before = /^[;, ]/.test(places);
  const begun = before ? `{0}${places.replace(/\{(\d+)\}/g, (_, i) => `{${Number(i) + 1}}`)}` : places;
  return / $/.test(begun) ? `${begun}{${next + (before ? 1 : 0)}}` : begun;
}
