// The texts of the page, in the chosen language. Sources contain them in English, which costs
// nothing; any other language is a bundle of its own (`words/`), loaded when it is chosen.
//
// Texts are translated where they become part of the page: `html` and `svg`, which replace lit's,
// translate the text of a template, its attributes, and strings inserted into it. So tables of
// words and the messages of worker and core stay English up to there. Use `t` for a text made of
// several pieces, and for one that reaches the page in another way than by a template:
//
//     t`${done} of ${all} scans`       t("Stop")
//
// A new sentence needs an entry in every language: `npm run types` names those that lack it.

import { html as litHtml, svg as litSvg, type TemplateResult } from "lit";
import { translator } from "./spoken.js";

/** A sentence with inserted values; an inserted English text may be in the catalogue, and is then
    translated as well. */
export function t(english: TemplateStringsArray | string, ...values: readonly unknown[]): string {
  const other = translator();
  if (typeof english === "string") return other ? other.say(english) : english;
  return other ? other.compose(english, values) : String.raw({ raw: english }, ...values);
}

export function html(strings: TemplateStringsArray, ...values: unknown[]): TemplateResult<1> {
  return translator()?.template(litHtml, strings, values) ?? litHtml(strings, ...values);
}

export function svg(strings: TemplateStringsArray, ...values: unknown[]): TemplateResult<2> {
  return translator()?.template(litSvg, strings, values) ?? litSvg(strings, ...values);
}
