// Makes ring.gzip, the recording that comes with the page: a drive all round the world `loop`, as
// its lidar and its wheels would log it, made by our own simulation.
//
//     simulate --world loop --sensor lidar --set lidar.beams=180 --seed 7 \
//         --method scan-matching --carmen ring.log
//     node make.mjs ring.log
//
// One scan in five is kept, with ranges to a centimetre: the robot drives 30 cm between two of
// them, and a lidar of this kind measures no better. The poses are odometry, not the truth.

import { readFileSync, writeFileSync } from "node:fs";
import { gzipSync } from "node:zlib";

const EVERY = 5;
/** Words of ROBOTLASER1 before its ranges; the last of them is the number of ranges. */
const HEAD = 9;
const RANGE_DIGITS = 2;
const POSE_DIGITS = 4;

const lines = readFileSync(process.argv[2], "utf8").trim().split("\n");
const [comments, scans] = [lines.filter((line) => !line.startsWith("ROBOTLASER1")), lines.filter((line) => line.startsWith("ROBOTLASER1"))];
const rounded = (word, digits) => (/^-?\d+\.\d+$/.test(word) ? String(Number(Number(word).toFixed(digits))) : word);
const thin = (line) => {
  const words = line.split(" ");
  const behind = HEAD + Number(words[HEAD - 1]);
  return words.map((word, i) => (i < HEAD ? word : rounded(word, i < behind ? RANGE_DIGITS : POSE_DIGITS))).join(" ");
};
const kept = scans.filter((_, i) => i % EVERY === 0).map(thin);
const text = [...comments, "# A simulated robot drives round the world `loop`; of five scans one, ranges to a centimetre", ...kept, ""].join("\n");
const packed = gzipSync(text, { level: 9 });
// Clear the time stamp of packing, which would make each build differ.
packed.fill(0, 4, 8);
writeFileSync(new URL("ring.gzip", import.meta.url), packed);
console.log(`${kept.length} scans, ${packed.length} bytes`);
