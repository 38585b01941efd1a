// ZIP archives off the page's main thread: lists one, unpacks its files and verifies their
// checksums, packs files into one. It uses zip.js without that library's own workers, and with the
// browser's own inflate.

import { BlobReader, BlobWriter, configure, type FileEntry, Uint8ArrayReader, ZipReader, ZipWriter } from "@zip.js/zip.js/lib/zip-core-external.js";
import type { ZipAnswer, ZipAsk, ZipFault } from "./zip.js";

configure({ useWebWorkers: false, useCompressionStream: true });

/** No recording is larger than this; an archive that is was made to fill the memory. */
const MOST_BYTES = 1 << 30;
/** Compressed already: compressing again costs time and gains nothing. */
const IS_PACKED = /\.(?:png|slamlab|gz)$/;

class Fault extends Error {
  constructor(readonly fault: ZipFault) {
    super(fault.kind);
  }
}

self.onmessage = ({ data }: MessageEvent<ZipAsk>): void => {
  const work = data.kind === "pack" ? packed(data.files) : data.kind === "unpack" ? unpacked(data.archive, data.wanted) : list(data.archive, data.most);
  work.then(answer, (error: unknown) => {
    if (!(error instanceof Fault)) console.warn(error);
    answer({ kind: "fault", fault: error instanceof Fault ? error.fault : { kind: "damaged" } });
  });
};

function answer(answer: ZipAnswer): void {
  postMessage(answer);
}

async function* entriesOf(archive: Blob): AsyncGenerator<FileEntry> {
  const reader = new ZipReader(new BlobReader(archive), { checkSignature: true });
  try {
    for await (const entry of reader.getEntriesGenerator()) {
      if (!entry.directory) yield entry;
    }
  } finally {
    await reader.close();
  }
}

async function list(archive: Blob, most: number): Promise<ZipAnswer> {
  const entries: { name: string; size: number }[] = [];
  for await (const { filename: name, uncompressedSize: size } of entriesOf(archive)) {
    // Files that macOS adds for itself are not listed.
    if (!/(?:^|\/)(?:__MACOSX\/|\.)/.test(name)) entries.push({ name, size });
    if (entries.length > most) throw new Fault({ kind: "many", most });
  }
  return { kind: "list", entries };
}

async function unpacked(archive: Blob, wanted: readonly string[]): Promise<ZipAnswer> {
  const files: { name: string; content: Blob }[] = [];
  const damaged: string[] = [];
  let sum = 0;
  for await (const entry of entriesOf(archive)) {
    const { filename: name, uncompressedSize: size } = entry;
    if (!wanted.includes(name)) continue;
    sum += size;
    if (sum > MOST_BYTES) throw new Fault({ kind: "large", name, size });
    const content = await contentOf(entry);
    if (content) files.push({ name, content });
    else damaged.push(name);
  }
  return { kind: "unpack", files, damaged };
}

/** Null if an entry does not match its checksum, or cannot be unpacked. */
async function contentOf(entry: FileEntry): Promise<Blob | null> {
  const pieces: BlobPart[] = [];
  let size = 0;
  const writable = new WritableStream<Uint8Array<ArrayBuffer>>({
    write(piece) {
      size += piece.length;
      // Stop at the declared size.
      if (size > entry.uncompressedSize) throw new Fault({ kind: "damaged" });
      pieces.push(piece.slice());
    },
  });
  try {
    await entry.getData(writable, { checkSignature: true });
  } catch (error) {
    console.warn(entry.filename, error);
    return null;
  }
  return size === entry.uncompressedSize ? new Blob(pieces) : null;
}

async function packed(files: readonly { name: string; bytes: Uint8Array<ArrayBuffer> }[]): Promise<ZipAnswer> {
  const writer = new ZipWriter(new BlobWriter("application/zip"));
  for (const { name, bytes } of files) await writer.add(name, new Uint8ArrayReader(bytes), { level: IS_PACKED.test(name) ? 0 : 6 });
  return { kind: "pack", archive: await writer.close() };
}
