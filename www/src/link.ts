// Experiments in an address, and in a file that holds one.

import type { SavedFile } from "./protocol/module.js";

/** Whether what stands behind the address, its `#` included, is an experiment; what is wrong with
    one is told by the core. */
export function isLink(hash: string): boolean {
  return hash.startsWith("#run&");
}

/** A file that opens this page at the experiment, as Windows, macOS and Linux know such files. */
export function linkFile(name: string, link: string): SavedFile {
  const { origin, pathname, search } = location;
  return { name, mime: "application/internet-shortcut", bytes: new TextEncoder().encode(`${SHORTCUT}\r\nURL=${origin}${pathname}${search}#${link}\r\n`) };
}

/** How such files begin. */
export const SHORTCUT = "[InternetShortcut]";

/** The experiment in the text of such a file, its `#` included, whatever server it is from; null
    where it leads elsewhere. */
export function linkIn(text: string): string | null {
  return /^URL=[^#\r\n]*(#run&[^\r\n]*)/m.exec(text)?.[1] ?? null;
}

/** What the address of a drawn world begins with behind its `#`, itself included. */
export const WORLD_PREFIX = "#world=";

/** Whether what stands behind the address is a drawn world; the editor reads it. */
export function isSharedWorld(hash: string): boolean {
  return hash.startsWith(WORLD_PREFIX);
}
