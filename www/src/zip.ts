// ZIP archives: files into one, and what is in one. Only for bundles that are loaded late.

import { unzipSync, Zip, ZipDeflate, ZipPassThrough } from "fflate";
import type { SavedFile } from "./protocol/module.js";
import { t } from "./words.js";

/** Bytes that are packed before the page may draw again. */
const PIECE = 1 << 18;
/** Larger files than that are no recordings, but an archive that was made to fill the memory. */
const MOST_BYTES = 1 << 30;
const MOST_FILES = 10_000;

/** Packed already: trying again costs time and gains nothing. */
const IS_PACKED = /\.(?:png|slamlab|gz)$/;

/** The page draws in between. */
const breathe = (): Promise<void> => new Promise((resolve) => setTimeout(resolve));

export async function packed(files: readonly SavedFile[]): Promise<Blob> {
  const pieces: Uint8Array<ArrayBuffer>[] = [];
  let fault: Error | null = null;
  const zip = new Zip((error, piece) => {
    if (error) fault = error;
    else pieces.push(new Uint8Array(piece));
  });
  for (const { name, bytes } of files) {
    const entry = IS_PACKED.test(name) ? new ZipPassThrough(name) : new ZipDeflate(name, { level: 6 });
    zip.add(entry);
    for (let at = 0; at < bytes.length; at += PIECE) {
      entry.push(bytes.subarray(at, at + PIECE));
      await breathe();
    }
    entry.push(new Uint8Array(0), true);
  }
  zip.end();
  if (fault) throw fault;
  return new Blob(pieces, { type: "application/zip" });
}

/** A file in an archive, before it is unpacked. */
export interface Entry {
  readonly name: string;
  readonly size: number;
}

export class ZipError extends Error {}

/** What is in it; folders, and what macOS adds for itself, are not listed. */
export function entriesOf(archive: Uint8Array): Entry[] {
  const entries: Entry[] = [];
  walk(archive, ({ name, originalSize }) => {
    if (!/\/$|(?:^|\/)(?:__MACOSX\/|\.)/.test(name)) entries.push({ name, size: originalSize });
    if (entries.length > MOST_FILES) throw new ZipError(t`it holds more than ${MOST_FILES} files`);
    return false;
  });
  return entries;
}

/** Unpacks these files of it, in this order. */
export function unpacked(archive: Uint8Array, wanted: readonly string[]): File[] {
  let sum = 0;
  const found = walk(archive, ({ name, originalSize }) => {
    if (!wanted.includes(name)) return false;
    sum += originalSize;
    if (sum > MOST_BYTES) throw new ZipError(t`${name} is too large: ${Math.round(originalSize / 1e6)} MB unpacked`);
    return true;
  });
  return wanted.flatMap((name) => {
    const bytes = found[name];
    return bytes ? [new File([new Uint8Array(bytes)], name.replace(/^.*\//, ""))] : [];
  });
}

function walk(archive: Uint8Array, filter: (entry: { name: string; originalSize: number }) => boolean): Record<string, Uint8Array> {
  try {
    return unzipSync(archive, { filter });
  } catch (error) {
    if (error instanceof ZipError) throw error;
    throw new ZipError(t`the archive is damaged, or packed in a way that this page cannot unpack`);
  }
}
