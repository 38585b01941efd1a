// What the browser keeps for this page. If storage is forbidden, nothing is kept.

/** The result of `use`; null if storage is forbidden. */
export function ifAllowed<T>(use: () => T): T | null {
  try {
    return use();
  } catch {
    return null;
  }
}
