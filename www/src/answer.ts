// How the worker answers the page.

import type { Answer, Fault } from "./protocol.js";

export function post(answer: Answer, transfer: Transferable[] = []): void {
  (self as unknown as { postMessage(message: Answer, transfer: Transferable[]): void }).postMessage(answer, transfer);
}

/** A result under its name, or in words why there is none: what was given is the giver's to mend. */
export function attempt<Name extends string, T>(name: Name, work: () => T): { [key in Name]: T | null } & { error: string } {
  let [result, error] = [null as T | null, ""];
  try {
    result = work();
  } catch (thrown) {
    error = faultOf(thrown).text;
  }
  return { [name]: result, error } as { [key in Name]: T | null } & { error: string };
}

/** Something could not be done. A fault of the program is an error; else what was given, by its name if it has one, cannot be used. */
export function fail(error: unknown, name = ""): void {
  const fault = faultOf(error);
  if (fault.kind === "internal") console.error(error);
  else console.warn(error);
  post({ kind: "failed", fault: { ...fault, text: `${name === "" ? "" : `${name}: `}${fault.text}` } });
}

/** What the module throws has a kind; whatever else is thrown is a fault of the program. */
export function faultOf(error: unknown): Fault {
  if (!(error instanceof Error)) return { kind: "internal", text: String(error) };
  const { kind = "internal" } = error as Error & Partial<Fault>;
  return { kind, text: error.message };
}
