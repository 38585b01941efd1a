// Experiments in an address.

/** Whether what stands behind the address, its `#` included, is an experiment; what is wrong with
    one is told by the core. */
export function isLink(hash: string): boolean {
  return hash.startsWith("#run&");
}
