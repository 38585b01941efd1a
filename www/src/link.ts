// Experiments in an address, and in a file that holds one.

import type { SavedFile } from "./protocol/module.js";

/** Whether what stands behind the address, its `#` included, is an experiment; what is wrong with
    one is told by the core. */
export function isLink(hash: string): boolean {
  return hash.startsWith("#run&");
}

/** Letters of an address that are said again in words. */
const MOST_SAID = 60;

/** What stands behind the address, for a sentence about it. */
export const saidOf = (hash: string): string => (hash.length > MOST_SAID ? `${hash.slice(0, MOST_SAID)}…` : hash);

/** Whether something stands behind the address that may be a link: a bridge's token is none. */
export const isSaid = (hash: string): boolean => hash.length > 1 && !new URLSearchParams(hash.slice(1)).has("token");

/** Letters of the longest link that goes into an address, and of the longest that goes through
    messengers: many cut a message there. */
export const MOST_ADDRESS = 64_000;
export const MOST_MESSAGE = 2_000;

/** Whether only this computer reaches a server of this name. */
export const isOwnAddress = (hostname: string): boolean => /^(localhost|127\.[\d.]+|\[::1\])$/.test(hostname);

/** The address of a link. */
export function addressOfLink(link: string): string {
  return `${location.origin}${location.pathname}${location.search}#${link}`;
}

/** A file that opens this page at the experiment, as Windows, macOS and Linux know such files. */
export function linkFile(name: string, link: string): SavedFile {
  return { name, mime: "application/internet-shortcut", bytes: new TextEncoder().encode(`${SHORTCUT}\r\nURL=${addressOfLink(link)}\r\n`) };
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
