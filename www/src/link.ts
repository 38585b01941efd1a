// Experiments in an address.

/** Whether what stands behind the address, its `#` included, is an experiment; what is wrong with
    one is told by the core. */
export function isLink(hash: string): boolean {
  return hash.startsWith("#run&");
}

/** Letters of the longest link that goes into an address, and of the longest that goes through
    messengers: many cut a message there. */
export const MOST_ADDRESS = 64_000;
export const MOST_MESSAGE = 2_000;

/** The address of a link. */
export function addressOfLink(link: string): string {
  return `${location.origin}${location.pathname}${location.search}#${link}`;
}

/** What the address of a drawn world begins with behind its `#`, itself included. */
export const WORLD_PREFIX = "#world=";

/** Whether what stands behind the address is a drawn world; the editor reads it. */
export function isSharedWorld(hash: string): boolean {
  return hash.startsWith(WORLD_PREFIX);
}
