// How the worker answers the page.

import { faultOf } from "./fault.js";
import type { Answer } from "./protocol.js";

export function post(answer: Answer, transfer: Transferable[] = []): void {
  (self as unknown as { postMessage(message: Answer, transfer: Transferable[]): void }).postMessage(answer, transfer);
}

/** A result under its name, or the reason why there is none: errors are returned, not thrown. */
export function attempt<Name extends string, T>(name: Name, work: () => T): { [key in Name]: T | null } & { error: string } {
  let [result, error] = [null as T | null, ""];
  try {
    result = work();
  } catch (thrown) {
    error = faultOf(thrown).text;
  }
  return { [name]: result, error } as { [key in Name]: T | null } & { error: string };
}

/** Whether the module itself failed: a panic is thrown as its text, a trap by the engine. Its state
    can no longer be relied on. */
const isBroken = (error: unknown): boolean => typeof error === "string" || error instanceof WebAssembly.RuntimeError;

/** Reports a failure: a bug of the program as an error, unusable input with its name if it has
    one. */
export function fail(error: unknown, name = ""): void {
  const { about, text } = faultOf(error);
  if (about === "internal") console.error(error);
  else console.warn(error);
  post({ kind: "failed", about, text: `${name === "" ? "" : `${name}: `}${text}`, isBroken: isBroken(error) });
}
