// How the worker answers the page.

import type { Answer } from "./protocol.js";

export function post(answer: Answer, transfer: Transferable[] = []): void {
  (self as unknown as { postMessage(message: Answer, transfer: Transferable[]): void }).postMessage(answer, transfer);
}

/** A result under its name, or in words why there is none: what was given is the giver's to mend. */
export function attempt<Name extends string, T>(name: Name, work: () => T): { [key in Name]: T | null } & { error: string } {
  let [result, error] = [null as T | null, ""];
  try {
    result = work();
  } catch (thrown) {
    error = wordsOf(thrown);
  }
  return { [name]: result, error } as { [key in Name]: T | null } & { error: string };
}

/** What was given cannot be used: that is the giver's to mend, and no fault of the page. */
export function refuse(name: string, error: unknown): void {
  console.warn(error);
  post({ kind: "failed", text: `${name === "" ? "" : `${name}: `}${wordsOf(error)}` });
}

export function fail(error: unknown): void {
  console.error(error);
  post({ kind: "failed", text: wordsOf(error) });
}

export function wordsOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}
