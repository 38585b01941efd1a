// ZIP archives: packs files into one, lists and unpacks them. Each task starts a worker, so that
// the page can draw meanwhile, and the ZIP code is loaded only then.

import type { SavedFile } from "./protocol/module.js";
import { t } from "./words.js";

const MOST_FILES = 10_000;

export type ZipFault = { kind: "damaged" } | { kind: "many"; most: number } | { kind: "large"; name: string; size: number };

export type ZipAsk =
  | { kind: "list"; archive: Blob; most: number }
  | { kind: "unpack"; archive: Blob; wanted: readonly string[] }
  | { kind: "pack"; files: readonly { name: string; bytes: Uint8Array<ArrayBuffer> }[] };

export type ZipAnswer =
  | { kind: "list"; entries: Entry[] }
  | { kind: "unpack"; files: { name: string; content: Blob }[]; damaged: string[] }
  | { kind: "pack"; archive: Blob }
  | { kind: "fault"; fault: ZipFault };

/** A file in an archive, before it is unpacked. */
export interface Entry {
  readonly name: string;
  readonly size: number;
}

export class ZipError extends Error {}

export async function packed(files: readonly SavedFile[]): Promise<Blob> {
  const { archive } = await ask("pack", { kind: "pack", files: files.map(({ name, bytes }) => ({ name, bytes })) });
  return archive;
}

/** Its contents; folders, and the files that macOS adds for itself, are not listed. */
export async function entriesOf(archive: Blob): Promise<readonly Entry[]> {
  return (await ask("list", { kind: "list", archive, most: MOST_FILES })).entries;
}

/** Unpacks these files of it, in this order; damaged ones are named. */
export async function unpacked(archive: Blob, wanted: readonly string[]): Promise<{ files: readonly File[]; damaged: readonly string[] }> {
  const { files, damaged } = await ask("unpack", { kind: "unpack", archive, wanted });
  const found = new Map(files.map(({ name, content }) => [name, content]));
  return {
    files: wanted.flatMap((name) => {
      const content = found.get(name);
      return content ? [new File([content], name.replace(/^.*\//, ""))] : [];
    }),
    damaged,
  };
}

function ask<Kind extends ZipAsk["kind"]>(kind: Kind, what: ZipAsk & { kind: Kind }): Promise<ZipAnswer & { kind: Kind }> {
  const worker = new Worker(new URL("zip_worker.js", import.meta.url), { type: "module", name: "slamlab-zip" });
  return new Promise<ZipAnswer & { kind: Kind }>((resolve, reject) => {
    worker.onmessage = ({ data }: MessageEvent<ZipAnswer>) => {
      if (data.kind === kind) resolve(data as ZipAnswer & { kind: Kind });
      else if (data.kind === "fault") reject(new ZipError(words(data.fault)));
    };
    worker.onerror = (event) => reject(new Error(event.message));
    worker.postMessage(what);
  }).finally(() => worker.terminate());
}

function words(fault: ZipFault): string {
  if (fault.kind === "many") return t`it holds more than ${fault.most} files`;
  if (fault.kind === "large") return t`${fault.name} is too large: ${Math.round(fault.size / 1e6)} MB unpacked`;
  return t`the archive is damaged, or packed in a way that this page cannot unpack`;
}
