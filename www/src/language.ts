// The language of the page: that of the browser on a first visit, that of a link (`?lang=`), or the
// choice of a person, which is kept. It can change at once, in the middle of a run.

import { type Language, LANGUAGES, language, speak, translator } from "./spoken.js";
import { ifAllowed } from "./storage.js";
import type { Translator } from "./words/translator.js";

/** The key under which the choice is kept, and its name in a link. */
export const KEPT = "slamlab-language";
export const PARAMETER = "lang";

/** Our language that a tag such as `hu-HU` names. */
function ours(tag: string | null | undefined): Language | null {
  const code = tag?.toLowerCase().split("-")[0] ?? "";
  return Object.hasOwn(LANGUAGES, code) ? (code as Language) : null;
}

/** Sets the language of this visit. English needs no file, so nobody waits for it. */
export async function startLanguage(): Promise<void> {
  const wanted = ours(new URLSearchParams(location.search).get(PARAMETER)) ?? ours(ifAllowed(() => localStorage.getItem(KEPT))) ?? navigator.languages.map(ours).find(Boolean) ?? "en";
  // If it cannot be loaded, the page works all the same.
  await load(wanted).catch((error: unknown) => console.warn(error));
}

export async function load(wanted: Language): Promise<void> {
  if (wanted === language()) return;
  const part = wanted === "en" ? null : (await import(new URL(`words_${wanted}.js`, import.meta.url).href)) as { default: Translator };
  translator()?.leave();
  speak(part?.default ?? null);
  part?.default.enter();
  document.documentElement.lang = wanted;
}
