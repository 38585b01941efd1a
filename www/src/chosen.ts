// Sorts files that were dropped or chosen together: a building, something else to open, or nothing
// that can be opened.

export type Chosen =
  | { kind: "nothing" }
  /** A map of ROS with its image, an OGmap.txt, a submap, or a floor plan. */
  | { kind: "building"; name: string; files: readonly File[] }
  /** A recording, a world or a preset: its contents decide. */
  | { kind: "file"; file: File }
  | { kind: "refused"; text: string };

/** What the page writes for other programs, and where the same is to be had in a form that it
    reads. */
const WRITTEN_ONLY: Readonly<Record<string, string>> = {
  dxf: "The floor plan that was saved with it (.svg) holds the same walls.",
  geojson: "Walls are in the floor plan that was saved with them (.svg), rooms are detected again in every map.",
  tum: "The log of the scans (CARMEN) gives the same way again.",
};

/** Bytes within which the first line of a log begins, comments before it. */
const HEAD = 4096;

/** Whether a text is a log of revolutions and no OGmap.txt, which has the same ending: its first
    line that says something begins with a sample. */
async function isRevolutionLog(file: File): Promise<boolean> {
  // That a file has gone is told where it is read as a whole.
  const head = await file.slice(0, HEAD).text().catch(() => "");
  return /^(?:\s*(?:#.*)?\n)*\s*[S_]_t:/.test(head);
}

export async function chosen(files: readonly File[]): Promise<Chosen> {
  const [file, ...more] = files;
  if (!file) return { kind: "nothing" };
  const ends = (pattern: RegExp): File | undefined => files.find(({ name }) => pattern.test(name));
  const [yaml, image] = [ends(/\.ya?ml$/i), ends(/\.(pgm|png)$/i)];
  if (files.length === 2 && yaml && image) return { kind: "building", name: yaml.name, files: [yaml, image] };
  if (more.length > 0) return { kind: "refused", text: `These are ${files.length} files: drop one at a time, or the YAML and the image of a map together.` };
  if (yaml) return { kind: "refused", text: `${yaml.name} is one half of a map: drop it together with the image that it names (.pgm or .png).` };
  if (image) return { kind: "refused", text: `${image.name} is one half of a map: drop it together with its YAML file.` };
  if (/\.txt$/i.test(file.name) && await isRevolutionLog(file)) return { kind: "file", file };
  if (/\.(svg|txt|smap)$/i.test(file.name)) return { kind: "building", name: file.name, files };
  const elsewhere = WRITTEN_ONLY[/\.(\w+)$/.exec(file.name)?.[1]?.toLowerCase() ?? ""];
  if (elsewhere !== undefined) return { kind: "refused", text: `${file.name} is for other programs: this page writes such files and does not read them. ${elsewhere}` };
  return { kind: "file", file };
}
