// Sorts files that were dropped or chosen together by what stands in them, whatever they are
// called: a building, something else to open, or nothing that can be opened.

import { SHORTCUT } from "./link.js";
import { t } from "./words.js";

export type Chosen =
  | { kind: "nothing" }
  /** A map of ROS with its image, an OGmap.txt, a submap, or a floor plan. */
  | { kind: "building"; name: string; files: readonly File[] }
  | { kind: "file"; file: File; content: Content }
  /** A ZIP archive: what is in it is looked at. */
  | { kind: "archive"; file: File }
  | { kind: "refused"; text: string };

/** What one file holds; of a log and of what nobody knows the module says more. */
export type Content = "world" | "preset" | "graph" | "saved-map" | "link" | "log";

type OpenedKind = Content | "yaml" | "image" | "building" | "archive";
type Kind = OpenedKind | { kind: "written"; words: string };

/** All that can be opened, in words, and how such files are usually called. */
const WORDS: Readonly<Record<Exclude<OpenedKind, "image">, string>> = {
  log: "a recording of ROS (.bag, .mcap) or of the bridge (.mcap), a CARMEN log (.clf, .log), a log of a rover with an RPLIDAR (.log), of four rangers (.csv) or of an RPLIDAR alone (.txt), also packed (.gz)",
  "saved-map": "a saved map (.slamlab)",
  graph: "a pose graph (.g2o)",
  world: "a world (.json)",
  preset: "settings that were fitted to a drive (.json)",
  archive: "what was saved together (.zip)",
  link: "the link of an experiment (.url)",
  building: "a floor plan (.svg), a submap (.smap), OGmap.txt",
  yaml: "or a map of ROS (.yaml with .pgm or .png)",
};
/** As a list for a sentence. */
export const opened = (): string => Object.values(WORDS).map((each) => t(each)).join(", ");

const NAMED: Readonly<Record<string, Kind>> = {
  json: "world", url: "link", g2o: "graph", slamlab: "saved-map", yaml: "yaml", yml: "yaml", pgm: "image", png: "image", svg: "building", smap: "building", txt: "building",
};

/** Bytes within which a file shows what it is, comments before it. */
const HEAD = 1 << 16;

/** What the page writes for other programs, and where the same is to be had in a form that it
    reads. */
const WRITTEN_ONLY: readonly (readonly [pattern: RegExp, words: string])[] = [
  [/^\s*0\s*\n\s*SECTION\b|^\s*999\s*\n/, "a drawing (DXF): the floor plan that was saved with it (.svg) holds the same walls."],
  [/^\s*\{[^]*"FeatureCollection"/, "GeoJSON: walls are in the floor plan that was saved with them (.svg), rooms are detected again in every map."],
  [/^(?:-?[\d.]+(?:e[+-]?\d+)?[ \t]+){7}-?[\d.]+(?:e[+-]?\d+)?[ \t]*\r?(?:\n|$)/i, "a trajectory (TUM): it tells where a robot was, and not what it saw. `evaluate --truth` compares a mapped log with it."],
];

/** A line of an OGmap.txt: width, height, resolution and origin, and nothing else. */
const OG_MAP = /^\d+\s+\d+\s+[\d.e-]+\s+-?[\d.e+-]+\s+-?[\d.e+-]+\s*$/i;

/** Of what is written for other programs, what it is. */
function writtenOnly(text: string): string {
  return WRITTEN_ONLY.find(([pattern]) => pattern.test(text))?.[1] ?? "";
}

/** By how it begins; null where that does not tell. */
function byContent(bytes: Uint8Array): Kind | null {
  const begins = (...sign: readonly number[]): boolean => sign.every((byte, at) => bytes[at] === byte);
  if (begins(0x89, 0x73, 0x6c, 0x61, 0x6d)) return "saved-map";
  if (begins(0x89, 0x50, 0x4e, 0x47)) return "image";
  if (begins(0x50, 0x4b, 0x03, 0x04)) return "archive";
  const text = new TextDecoder().decode(bytes);
  if (/^P[25]\s/.test(text)) return "image";
  // Bytes that are no text are named by the module where they are no recording.
  if (text.includes("\0") || text.startsWith("#ROSBAG")) return "log";
  // The first line that says something.
  const said = text.replace(/^\uFEFF?(?:[ \t]*(?:#(?!points|robot|landmarks).*)?\r?\n)*/, "");
  const first = said.slice(0, Math.max(0, said.search(/\r?\n|$/)));
  if (/^(?:VERTEX|EDGE|FIX)(?:_|\b)/.test(first)) return "graph";
  if (/^#(?:points|robot|landmarks)/.test(first)) return "building";
  if (/^\s*<(?:\?xml|svg|!--)/i.test(first) && /<svg\b/i.test(text)) return "building";
  if (/^\s*<(?:!doctype )?html/i.test(first)) return "log";
  if (text.startsWith(SHORTCUT)) return "link";
  if (OG_MAP.test(first)) return "building";
  if (/^image\s*:/m.test(said)) return "yaml";
  const words = writtenOnly(said);
  if (words !== "") return { kind: "written", words };
  if (/^\s*\{/.test(first)) return text.includes('"slamlab_preset"') ? "preset" : "world";
  return /^(?:[FR]LASER|ROBOTLASER\d|ODOM|PARAM|[S_]_t:)/.test(first) ? "log" : null;
}

/** By what it is called: what is damaged at its begin is told so by whoever reads such files. */
function byName(name: string): Kind {
  const ending = /\.(\w+)$/.exec(name)?.[1]?.toLowerCase() ?? "";
  return NAMED[ending] ?? "log";
}

async function kindOf(file: File): Promise<Kind> {
  // That a file has gone is told where it is read as a whole.
  const head = await file.slice(0, HEAD).arrayBuffer().catch(() => new ArrayBuffer(0));
  return byContent(new Uint8Array(head)) ?? byName(file.name);
}

export async function chosen(files: readonly File[]): Promise<Chosen> {
  const [file, ...more] = files;
  if (!file) return { kind: "nothing" };
  const kinds = await Promise.all(files.map(kindOf));
  const [yaml, image] = [files[kinds.indexOf("yaml")], files[kinds.indexOf("image")]];
  if (files.length === 2 && yaml && image) return { kind: "building", name: yaml.name, files: [yaml, image] };
  if (more.length > 0) return { kind: "refused", text: t`These are ${files.length} files: drop one at a time, or the YAML and the image of a map together.` };
  const [kind = "log"] = kinds;
  if (kind === "yaml") return { kind: "refused", text: t`${file.name} is one half of a map: drop it together with the image that it names (.pgm or .png).` };
  if (kind === "image") return { kind: "refused", text: t`${file.name} is a picture. If it is one half of a map, drop it together with its YAML file.` };
  if (typeof kind === "object") return { kind: "refused", text: t`${file.name} is for other programs: this page does not read it. It is ${kind.words}` };
  if (kind === "building") return { kind: "building", name: file.name, files };
  if (kind === "archive") return { kind: "archive", file };
  return { kind: "file", file, content: kind };
}
