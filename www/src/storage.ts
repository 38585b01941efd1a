// What the browser keeps for this page. Storage may be forbidden: then nothing is kept.

/** What `use` returns; null where storage is forbidden. */
export function ifAllowed<T>(use: () => T): T | null {
  try {
    return use();
  } catch {
    return null;
  }
}
