// Sorts files that were dropped or chosen together by content, whatever their names: a building,
// something else to open, or nothing that can be opened.

import { SHORTCUT } from "./link.js";
import { t } from "./words.js";

export type Chosen =
  | { kind: "nothing" }
  /** A ROS map with its image, an OGmap.txt, a submap, or a floor plan. */
  | { kind: "building"; name: string; files: readonly File[] }
  | { kind: "file"; file: File; content: Content }
  /** Poses over time, alone or with the recording that they belong to. */
  | { kind: "poses"; poses: File; log: File | null }
  /** A ZIP archive; its contents are looked at. */
  | { kind: "archive"; file: File }
  | { kind: "refused"; text: string };

/** What one file holds. Of logs and of unknown files, the module finds out more. */
export type Content = "world" | "preset" | "graph" | "saved-map" | "link" | "log";

type OpenedKind = Content | "poses" | "yaml" | "image" | "building" | "archive";
type Kind = OpenedKind | { kind: "written"; words: string };

/** All that can be opened, in words, and the usual names of such files. */
const WORDS: Readonly<Record<Exclude<OpenedKind, "image">, string>> = {
  log: "a recording of ROS (.bag, .mcap) or of the bridge (.mcap), a CARMEN log (.clf, .log), a log of a rover with an RPLIDAR (.log), of four rangers (.csv) or of an RPLIDAR alone (.txt), also packed (.gz)",
  poses: "poses over time, with a recording or beside one (TUM or CSV)",
  "saved-map": "a saved map (.slamlab)",
  graph: "a pose graph (.g2o)",
  world: "a world (.json)",
  preset: "settings that were fitted to a drive (.json)",
  archive: "what was saved together (.zip)",
  link: "the link of an experiment (.url)",
  building: "a floor plan (.svg), a submap (.smap), OGmap.txt",
  yaml: "or a map of ROS (.yaml with .pgm or .png)",
};
/** All of these as a list for a sentence. */
export const opened = (): string => Object.values(WORDS).map((each) => t(each)).join(", ");

const NAMED: Readonly<Record<string, Kind>> = {
  json: "world", url: "link", g2o: "graph", tum: "poses", slamlab: "saved-map", yaml: "yaml", yml: "yaml", pgm: "image", png: "image", svg: "building", smap: "building", txt: "building",
};

/** Bytes at the beginning of a file that show what it is; comments may come first. */
const HEAD = 1 << 16;

/** Files that the page writes for other programs, and how to save the same in a form that it
    reads. */
const WRITTEN_ONLY: readonly (readonly [pattern: RegExp, words: string])[] = [
  [/^\s*0\s*\n\s*SECTION\b|^\s*999\s*\n/, "a drawing (DXF): the floor plan that was saved with it (.svg) holds the same walls."],
  [/^\s*\{[^]*"FeatureCollection"/, "GeoJSON: walls are in the floor plan that was saved with them (.svg), rooms are detected again in every map."],
];

/** A line of an OGmap.txt: width, height, resolution and origin, and nothing else. */
const OG_MAP = /^\d+\s+\d+\s+[\d.e-]+\s+-?[\d.e+-]+\s+-?[\d.e+-]+\s*$/i;

/** A line of a TUM trajectory: eight numbers, separated by blanks. */
const TUM = /^(?:-?[\d.]+(?:e[+-]?\d+)?[ \t]+){7}-?[\d.]+(?:e[+-]?\d+)?[ \t]*$/i;

/** Column names of a table of poses, followed by units. A rangers' log has more columns. */
const COLUMNS: readonly RegExp[] = [
  /^(?:time|t|timestamp|stamp|secs?|seconds|s)(?:[_ ]?[[(]?(?:m|u|µ|n)?s(?:ec)?s?[\])]?)?$/,
  /^(?:(?:pos|position|pose)_|[tp])?x\b|^(?:(?:pos|position|pose)_|[tp])?x_/,
  /^(?:(?:pos|position|pose)_|[tp])?y\b|^(?:(?:pos|position|pose)_|[tp])?y_/,
  /^(?:theta|th|yaw|heading|phi|psi|angle|θ|φ|ψ|qz)(?![a-z])/,
];

/** Whether a line, which may be a comment, names the columns of poses. */
function namesPoses(line: string): boolean {
  const names = line.replace(/^\s*#/, "").split(/[,;\t]| (?![[(])/).map((name) => name.trim().replace(/^"|"$/g, "").toLowerCase());
  return COLUMNS.every((column) => names.some((name) => column.test(name))) && !names.includes("range0");
}

/** What a file is that the page writes only for other programs. */
function writtenOnly(text: string): string {
  return WRITTEN_ONLY.find(([pattern]) => pattern.test(text))?.[1] ?? "";
}

/** The kind, judged by the beginning of the file; null if that does not decide. */
function byContent(bytes: Uint8Array): Kind | null {
  const begins = (...sign: readonly number[]): boolean => sign.every((byte, at) => bytes[at] === byte);
  if (begins(0x89, 0x73, 0x6c, 0x61, 0x6d)) return "saved-map";
  if (begins(0x89, 0x50, 0x4e, 0x47)) return "image";
  if (begins(0x50, 0x4b, 0x03, 0x04)) return "archive";
  const text = new TextDecoder().decode(bytes);
  if (/^P[25]\s/.test(text)) return "image";
  // The module names binary files if they are no recording.
  if (text.includes("\0") || text.startsWith("#ROSBAG")) return "log";
  // The first line with content.
  const said = text.replace(/^\uFEFF?(?:[ \t]*(?:#(?!points|robot|landmarks).*)?\r?\n)*/, "");
  const first = said.slice(0, Math.max(0, said.search(/\r?\n|$/)));
  if (/^(?:VERTEX|EDGE|FIX)(?:_|\b)/.test(first)) return "graph";
  if (/^#(?:points|robot|landmarks)/.test(first)) return "building";
  if (/^\s*<(?:\?xml|svg|!--)/i.test(first) && /<svg\b/i.test(text)) return "building";
  if (/^\s*<(?:!doctype )?html/i.test(first)) return "log";
  if (text.startsWith(SHORTCUT)) return "link";
  if (OG_MAP.test(first)) return "building";
  if (/^image\s*:/m.test(said)) return "yaml";
  if (TUM.test(first) || namesPoses(first)) return "poses";
  // The header may be in a comment above the numbers.
  if (/^[-+\d.]/.test(first) && text.slice(0, text.length - said.length).split(/\r?\n/).some(namesPoses)) return "poses";
  const words = writtenOnly(said);
  if (words !== "") return { kind: "written", words };
  if (/^\s*\{/.test(first)) return text.includes('"slamlab_preset"') ? "preset" : "world";
  return /^(?:[FR]LASER|ROBOTLASER\d|ODOM|PARAM|[S_]_t:)/.test(first) ? "log" : null;
}

/** The kind, judged by the name. If the beginning of a file is damaged, the reader of its format
    reports it. */
function byName(name: string): Kind {
  const ending = /\.(\w+)$/.exec(name)?.[1]?.toLowerCase() ?? "";
  return NAMED[ending] ?? "log";
}

async function kindOf(file: File): Promise<Kind> {
  // A file that is gone is reported when the whole file is read.
  const head = await file.slice(0, HEAD).arrayBuffer().catch(() => new ArrayBuffer(0));
  return byContent(new Uint8Array(head)) ?? byName(file.name);
}

export async function chosen(files: readonly File[]): Promise<Chosen> {
  const [file, ...more] = files;
  if (!file) return { kind: "nothing" };
  const kinds = await Promise.all(files.map(kindOf));
  const [yaml, image] = [files[kinds.indexOf("yaml")], files[kinds.indexOf("image")]];
  if (files.length === 2 && yaml && image) return { kind: "building", name: yaml.name, files: [yaml, image] };
  const [poses, log] = [files[kinds.indexOf("poses")], files[kinds.indexOf("log")]];
  if (files.length === 2 && poses && log) return { kind: "poses", poses, log };
  if (more.length > 0) return { kind: "refused", text: t`These are ${files.length} files: drop one at a time, the YAML and the image of a map together, or a recording and its poses.` };
  const [kind = "log"] = kinds;
  if (kind === "yaml") return { kind: "refused", text: t`${file.name} is one half of a map: drop it together with the image that it names (.pgm or .png).` };
  if (kind === "image") return { kind: "refused", text: t`${file.name} is a picture. If it is one half of a map, drop it together with its YAML file.` };
  if (typeof kind === "object") return { kind: "refused", text: t`${file.name} is for other programs: this page does not read it. It is ${kind.words}` };
  if (kind === "poses") return { kind: "poses", poses: file, log: null };
  if (kind === "building") return { kind: "building", name: file.name, files };
  if (kind === "archive") return { kind: "archive", file };
  return { kind: "file", file, content: kind };
}
