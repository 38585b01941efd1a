// Experiments in an address.

/** Whether what stands behind the address, its `#` included, is an experiment; what is wrong with
    one is told by the core. */
export function isLink(hash: string): boolean {
  return hash.startsWith("#run&");
}

/** What the address of a drawn world begins with behind its `#`, itself included. */
export const WORLD_PREFIX = "#world=";

/** Whether what stands behind the address is a drawn world; the editor reads it. */
export function isSharedWorld(hash: string): boolean {
  return hash.startsWith(WORLD_PREFIX);
}
