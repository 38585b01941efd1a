// Words of programs within a sentence, which stand between backticks.

import type { TemplateResult } from "lit";
import { html } from "../words.js";

/** The sentence with what stands between backticks as code. */
export function withCode(text: string): (string | TemplateResult)[] {
  return text.split("`").map((part, i) => (i % 2 === 1 ? html`<code>${part}</code>` : part));
}
