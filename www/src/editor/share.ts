// A drawing in an address: its file, compressed and encoded in letters that an address allows.
// `#world=…`

import { WORLD_PREFIX as PREFIX } from "../link.js";
import { t } from "../words.js";

/** Longer ones are not read, bytes: compressed, and uncompressed. */
const MOST_PACKED = 64_000;
const MOST_TEXT = 4_000_000;

/** The part of the address from `#` on that holds this text.

    Throws if the text is too long for an address. */
export async function sharedHash(text: string): Promise<string> {
  const compact = JSON.stringify(JSON.parse(text));
  const packed = await throughStream(new TextEncoder().encode(compact), new CompressionStream("deflate-raw"), MOST_TEXT);
  let letters = "";
  for (const byte of packed) letters += String.fromCharCode(byte);
  const hash = PREFIX + btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
  if (hash.length > MOST_PACKED) throw new Error(t`The drawing is too large for a link: ${hash.length} letters, at most ${MOST_PACKED}. Save it as a file instead.`);
  return hash;
}

/** The text of the file in an address.

    If there is none, throws an error with a sentence for people. */
export async function sharedWorld(hash: string): Promise<string> {
  if (hash.length > MOST_PACKED) throw new Error(t`The link to a world has ${hash.length} letters, at most ${MOST_PACKED} are read.`);
  try {
    const letters = atob(hash.slice(PREFIX.length).replaceAll("-", "+").replaceAll("_", "/"));
    const packed = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
    return new TextDecoder("utf-8", { fatal: true }).decode(await throughStream(packed, new DecompressionStream("deflate-raw"), MOST_TEXT));
  } catch {
    throw new Error("The link to a world is damaged: it was perhaps not copied as a whole.");
  }
}

/** The output of the stream, of at most `most` bytes: a small input can expand to a huge one. */
async function throughStream(bytes: Uint8Array<ArrayBuffer>, stream: CompressionStream | DecompressionStream, most: number): Promise<Uint8Array> {
  const parts: Uint8Array[] = [];
  let length = 0;
  const reader = new Blob([bytes]).stream().pipeThrough(stream).getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    length += value.length;
    if (length > most) {
      await reader.cancel();
      throw new RangeError(t`more than ${most} bytes`);
    }
    parts.push(value);
  }
  const all = new Uint8Array(length);
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}
