// What was decided, and why, with the time of the run.

import { css, type TemplateResult } from "lit";
import { html } from "../words.js";
import { SlamElement } from "./element.js";
import { clock } from "./format.js";

export class SlamLog extends SlamElement {
  static override styles = css`
    :host { display: flex; flex-direction: column; min-height: 120px; }
    /* Room for a dozen entries, where there is a page to scroll. */
    @media (min-width: 761px) { :host { min-height: min(420px, 60dvh); } }
    h2 { margin-bottom: 10px; }
    ol { list-style: none; margin: 0; padding: 0; overflow-y: auto; flex: 1; font-size: 12.5px; line-height: 1.4; }
    li { display: grid; grid-template-columns: 42px 1fr; gap: 8px; padding: 3px 0; }
    time { font-family: var(--mono); color: var(--muted); }
    .moment { justify-content: start; min-height: 0; padding: 0; border: 0; background: transparent; font-size: inherit; text-decoration: underline dotted var(--line-strong); text-underline-offset: 3px; }
    b { color: var(--muted); font-weight: 500; }
    .good { color: var(--good-ink); }
    .warn { color: var(--warn-ink); }
  `;

  protected override readonly topics = ["log"] as const;

  override render(): TemplateResult {
    const entries = [...this.store.log].reverse();
    const isPast = this.store.source !== "bridge";
    return html`<h2>Log</h2>
      <ol data-testid="log" tabindex="0" aria-label="Log, newest first">
        ${entries.length === 0 ? html`<li><time></time><span class="muted">Nothing yet.</span></li>` : ""}
        ${entries.map((e) => html`<li class=${e.level}>${isPast ? html`<button class="moment" title="Go to this moment" @click=${this.press(() => this.client.seek(e.time))}><time>${clock(e.time)}</time></button>` : html`<time>${clock(e.time)}</time>`}<span>${e.text}${e.count > 1 ? html` <b class="num" title="The newest of ${e.count}">×${e.count}</b>` : ""}</span></li>`)}
      </ol>`;
  }
}

customElements.define("slam-log", SlamLog);
