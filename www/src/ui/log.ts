// What was decided, and why, with the run time: as lines that open to all their entries, filtered
// by kind or words, and saved as a table.

import { css, nothing, type TemplateResult } from "lit";
import type { Column } from "../csv.js";
import { KINDS, linesOf, listed, MOST_ENTRIES, type LogEntry, type LogKind, type LogLine } from "../log.js";
import { html, t } from "../words.js";
import "./csv_button.js";
import { SlamElement } from "./element.js";
import { clock } from "./format.js";
import { valueOf } from "./input.js";

const TITLES: Readonly<Record<LogKind, string>> = { all: "Everything", info: "Decisions and progress", warn: "Warnings", good: "What went well" };

export class SlamLog extends SlamElement {
  static override styles = css`
    :host { display: flex; flex-direction: column; min-height: 120px; }
    /* Room for a dozen entries, where there is a page to scroll. */
    @media (min-width: 761px) { :host { min-height: min(420px, 60dvh); } }
    h2 { margin-bottom: 10px; }
    .tools { display: flex; flex-wrap: wrap; gap: 6px; margin-bottom: 8px; }
    .tools select { flex: 1 1 120px; width: auto; min-width: 0; }
    .tools input { order: 1; flex: 1 1 100%; min-width: 0; min-height: 36px; padding: 0 10px; border: 1px solid var(--line); border-radius: 9px; background: var(--raised); }
    slam-csv { margin: 0; align-self: center; }
    ol { list-style: none; margin: 0; padding: 0; overflow-y: auto; flex: 1; font-size: 12.5px; line-height: 1.4; }
    li { display: grid; grid-template-columns: 42px 1fr; gap: 8px; padding: 3px 0; }
    ol ol { grid-column: 1 / -1; margin-left: 14px; max-height: 40dvh; border-left: 2px solid var(--line); padding-left: 8px; }
    time { font-family: var(--mono); color: var(--muted); }
    .moment, .fold { justify-content: start; min-height: 0; padding: 0; border: 0; background: transparent; font-size: inherit; text-decoration: underline dotted var(--line-strong); text-underline-offset: 3px; }
    .fold { display: inline-flex; gap: 3px; padding: 0 4px; font-weight: 500; color: var(--accent-ink); }
    @media (pointer: coarse) { .moment, .fold { min-height: 32px; } li { align-items: baseline; } }
    .good { color: var(--good-ink); }
    .warn { color: var(--warn-ink); }
    p { margin: 6px 0 0; font-size: 12.5px; color: var(--muted); }
  `;

  protected override readonly topics = ["log"] as const;
  #kind: LogKind = "all";
  #search = "";
  /** Topics of the lines that are open. */
  readonly #open = new Set<string>();

  override render(): TemplateResult {
    const { log } = this.store;
    const entries = this.#listed();
    return html`<h2>Log</h2>
      <div class="tools">
        <select data-testid="log-kind" aria-label="What to list" @change=${(e: Event) => { this.#kind = valueOf(e) as LogKind; this.requestUpdate(); }}>
          ${KINDS.map((kind) => html`<option value=${kind} .selected=${kind === this.#kind}>${TITLES[kind]}</option>`)}</select>
        <input type="search" data-testid="log-search" placeholder="Search the log" aria-label="Search the log" .value=${this.#search} @input=${(e: Event) => { this.#search = valueOf(e); this.requestUpdate(); }}>
        <slam-csv .name=${"log"} .columns=${() => columnsOf(this.#listed())}></slam-csv>
      </div>
      <ol data-testid="log" tabindex="0" aria-label="Log, newest first">
        ${entries.length === 0 ? html`<li><time></time><span class="muted">${log.length === 0 ? "Nothing yet." : "Nothing of that kind."}</span></li>` : ""}
        ${linesOf(entries).map((line) => this.#line(line))}
      </ol>
      ${log.length >= MOST_ENTRIES ? html`<p>Of so long a run only ${MOST_ENTRIES} entries are kept.</p>` : nothing}`;
  }

  #listed(): readonly LogEntry[] {
    return listed(this.store.log, this.#kind, this.#search, t);
  }

  #line({ newest, earlier }: LogLine): TemplateResult {
    const { topic } = newest;
    const isOpen = topic !== undefined && this.#open.has(topic);
    const label = isOpen ? t`Hide the ${earlier.length} before` : t`Show the ${earlier.length} before`;
    return html`<li class=${newest.level}>${this.#time(newest)}<span>${newest.text}${topic !== undefined && earlier.length > 0
      ? html` <button class="fold num" data-testid="log-fold" aria-expanded=${isOpen} aria-label=${label} title=${label} @click=${() => this.#fold(topic)}>×${earlier.length + 1} ${isOpen ? "▴" : "▾"}</button>` : nothing}</span>
      ${isOpen ? html`<ol>${earlier.map((entry) => html`<li class=${entry.level}>${this.#time(entry)}<span>${entry.text}</span></li>`)}</ol>` : nothing}</li>`;
  }

  /** A run that is not live can go back to the moment of an entry. */
  #time({ time }: LogEntry): TemplateResult {
    if (this.store.source === "bridge") return html`<time>${clock(time)}</time>`;
    return html`<button class="moment" title="Go to this moment" @click=${this.press(() => this.client.seek(time))}><time>${clock(time)}</time></button>`;
  }

  #fold(topic: string): void {
    if (!this.#open.delete(topic)) this.#open.add(topic);
    this.requestUpdate();
  }
}

/** The oldest entry first, as usual in other programs. */
function columnsOf(entries: readonly LogEntry[]): readonly Column[] {
  return [
    { title: "Time", unit: "s", values: entries.map(({ time }) => time) },
    { title: "Level", unit: "", values: entries.map(({ level }) => level) },
    { title: "Text", unit: "", values: entries.map(({ text }) => t(text)) },
  ];
}

customElements.define("slam-log", SlamLog);
