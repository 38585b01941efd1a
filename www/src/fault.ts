// Puts what was thrown into words.

import type { ErrorKind } from "./protocol/module.js";

/** An error of the module names its kind; anything else that is thrown is a bug of the program. */
export function faultOf(error: unknown): { about: ErrorKind; text: string } {
  if (!(error instanceof Error)) return { about: "internal", text: String(error) };
  const { kind = "internal" } = error as Error & { kind?: ErrorKind };
  return { about: kind, text: error.message };
}
