// Code within a sentence, marked by backticks.

import type { TemplateResult } from "lit";
import { html } from "../words.js";

/** The sentence with the text between backticks as code. */
export function withCode(text: string): (string | TemplateResult)[] {
  return text.split("`").map((part, i) => (i % 2 === 1 ? html`<code>${part}</code>` : part));
}
