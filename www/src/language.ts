// The language of the page: chosen by the browser's on a first visit, by `?lang=` in a link, or by a
// person, whose choice is kept. It changes at once, in the middle of a run.

import { type Language, LANGUAGES, language, speak } from "./spoken.js";
import { ifAllowed } from "./storage.js";
import { t } from "./words.js";
import type { Translator } from "./words/translator.js";

const KEPT = "slamlab-language";
const PARAMETER = "lang";
/** Heard when another language is spoken. */
export const LANGUAGE_CHANGED = "language-changed";

/** The code of one of ours that a tag as `hu-HU` names. */
function ours(tag: string | null | undefined): Language | null {
  const code = tag?.toLowerCase().split("-")[0] ?? "";
  return Object.hasOwn(LANGUAGES, code) ? (code as Language) : null;
}

/** Speaks the language of this visit. English needs nothing, so that nobody waits for it. */
export async function startLanguage(): Promise<void> {
  const asked = ours(new URLSearchParams(location.search).get(PARAMETER)) ?? ours(ifAllowed(() => localStorage.getItem(KEPT)));
  const wanted = asked ?? navigator.languages.map(ours).find((each) => each !== null) ?? "en";
  // Where it does not come, the page is there all the same.
  if (wanted !== "en") await load(wanted).catch((error: unknown) => console.warn("slamlab: the language did not come", error));
}

/** Speaks another one from here on, and remembers it. */
export async function choose(wanted: Language): Promise<void> {
  await load(wanted);
  ifAllowed(() => localStorage.setItem(KEPT, wanted));
  // The choice stands, not the link that the page was opened by.
  const url = new URL(location.href);
  if (url.searchParams.has(PARAMETER)) {
    url.searchParams.delete(PARAMETER);
    history.replaceState(history.state, "", url);
  }
  dispatchEvent(new Event(LANGUAGE_CHANGED));
}

async function load(wanted: Language): Promise<void> {
  if (wanted === language()) return;
  const part = wanted === "en" ? null : (await import(new URL(`words_${wanted}.js`, import.meta.url).href)) as { default: Translator };
  speak(part?.default ?? null);
  document.documentElement.lang = wanted;
  nameParts();
}

/** What index.html says itself, in English. */
const said = new Map<Element, string>();
let title = "";

function nameParts(): void {
  title ||= document.title;
  document.title = t(title);
  for (const part of document.querySelectorAll("#stage [aria-label], #side, #side [aria-label]")) {
    const english = said.get(part) ?? part.getAttribute("aria-label") ?? "";
    said.set(part, english);
    part.setAttribute("aria-label", t(english));
  }
}
