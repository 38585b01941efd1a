// What people read, in the language that they chose. Sources say it in English, which costs
// nothing; any other language is a bundle of its own (`words/`), which comes when it is chosen.
//
// Words are looked up where they become part of the page: `html` and `svg`, which stand in place of
// lit's, look up the text of a template, what its attributes say, and strings in its places. So
// tables of words, and what worker and core tell, stay English up to there. What is put together of
// several pieces is said by `t`, and so is what goes to the page by another way than a template:
//
//     t`${done} of ${all} scans`       t("Stop")
//
// A new sentence is a new entry of every language: `npm run types` names those that lack it.

import { html as litHtml, svg as litSvg, type TemplateResult } from "lit";
import { translator } from "./spoken.js";

/** A sentence, with what stands in its places; what is there in English may be a word of ours, and
    is looked up as well. */
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
