// Experiments in an address, and in a file that holds one.

import type { SavedFile } from "./protocol/module.js";

/** Whether the end of the address, including its `#`, is an experiment; the core reports errors in
    it. */
export function isLink(hash: string): boolean {
  return hash.startsWith("#run&");
}

/** Letters of an address that a message repeats. */
const MOST_SAID = 60;

/** The end of the address, shortened for a sentence about it. */
export const saidOf = (hash: string): string => (hash.length > MOST_SAID ? `${hash.slice(0, MOST_SAID)}…` : hash);

/** Whether the end of the address may be a link: a bridge's token is none. */
export const isSaid = (hash: string): boolean => hash.length > 1 && !new URLSearchParams(hash.slice(1)).has("token");

/** Letters of the longest link that fits into an address, and of the longest that messengers pass
    on: many cut a message there. */
export const MOST_ADDRESS = 64_000;
export const MOST_MESSAGE = 2_000;

/** Whether a server of this name can be reached from this computer only. */
export const isOwnAddress = (hostname: string): boolean => /^(localhost|127\.[\d.]+|\[::1\])$/.test(hostname);

/** The address of a link. */
export function addressOfLink(link: string): string {
  return `${location.origin}${location.pathname}${location.search}#${link}`;
}

/** A file that opens this page at the experiment, in a form that Windows, macOS and Linux know. */
export function linkFile(name: string, link: string): SavedFile {
  return { name, mime: "application/internet-shortcut", bytes: new TextEncoder().encode(`${SHORTCUT}\r\nURL=${addressOfLink(link)}\r\n`) };
}

/** The beginning of such files. */
export const SHORTCUT = "[InternetShortcut]";

/** The experiment in the text of such a file, including its `#`, whatever its server; null if it
    leads elsewhere. */
export function linkIn(text: string): string | null {
  return /^URL=[^#\r\n]*(#run&[^\r\n]*)/m.exec(text)?.[1] ?? null;
}

/** The beginning of a drawn world in an address, including the `#`. */
export const WORLD_PREFIX = "#world=";

/** Whether the end of the address is a drawn world; the editor reads it. */
export function isSharedWorld(hash: string): boolean {
  return hash.startsWith(WORLD_PREFIX);
}
