// Which language is spoken, for all who say something. Bundles have copies of this file, and all
// speak one language; a worker's is English, and the page translates what it is told.

import type { Translator } from "./words/translator.js";

/** Languages by their own names, as BCP 47 has them. */
export const LANGUAGES = { en: "English", hu: "Magyar", cs: "Čeština", pl: "Polski" } as const;
export type Language = keyof typeof LANGUAGES;

/** Heard when another language is spoken. */
export const LANGUAGE_CHANGED = "language-changed";

interface Spoken { translator: Translator | null }
const KEY = Symbol.for("slamlab.words");
const spoken: Spoken = ((globalThis as { [KEY]?: Spoken })[KEY] ??= { translator: null });

/** Null for English. */
export function speak(translator: Translator | null): void {
  spoken.translator = translator;
}

export function translator(): Translator | null {
  return spoken.translator;
}

export function language(): Language {
  return spoken.translator?.language ?? "en";
}

/** What stands between whole and fraction. */
export function decimalMark(): string {
  return spoken.translator?.decimalMark ?? ".";
}

/** Names a word that is said elsewhere: so it is in the catalogue, though it does not read like a
    sentence. */
export const word = <T extends string>(english: T): T => english;
