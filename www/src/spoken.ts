// The current language, for all code that shows text. Bundles have copies of this file, and all use
// one language; a worker uses English, and the page translates its messages.

import type { Translator } from "./words/translator.js";

/** Languages by their own names, with BCP 47 tags. */
export const LANGUAGES = { en: "English", hu: "Magyar", cs: "Čeština", pl: "Polski" } as const;
export type Language = keyof typeof LANGUAGES;

/** Dispatched when the language changes. */
export const LANGUAGE_CHANGED = "language-changed";

interface Spoken { translator: Translator | null }
const KEY = Symbol.for("slamlab.words");
const spoken: Spoken = ((globalThis as { [KEY]?: Spoken })[KEY] ??= { translator: null });

/** Sets the translator; null for English. */
export function speak(translator: Translator | null): void {
  spoken.translator = translator;
}

export function translator(): Translator | null {
  return spoken.translator;
}

export function language(): Language {
  return spoken.translator?.language ?? "en";
}

/** The decimal mark. */
export function decimalMark(): string {
  return spoken.translator?.decimalMark ?? ".";
}

/** Marks a word that is shown elsewhere, so that it is in the catalogue although it does not look
    like a sentence. */
export const word = <T extends string>(english: T): T => english;
