// Recordings of the bridge, on its disk and in object storage: a list with the upload progress,
// from which each can be opened. A bundle of its own, loaded when somebody looks.

import { css, nothing, type TemplateResult } from "lit";
import { word } from "../spoken.js";
import { html, t } from "../words.js";
import { SlamElement } from "./element.js";
import { fixed } from "./format.js";

interface Recording {
  readonly name: string;
  readonly bytes: number;
  readonly here: boolean;
  readonly stored: boolean;
  readonly current: boolean;
  /** The part that has been stored, 0 to 1. */
  readonly part: number;
}

interface List {
  readonly store: string;
  readonly fault: string | null;
  readonly recordings: readonly Recording[];
}

/** The longest list; for more, use the tools of the store. */
const MOST = 50;
const MEBIBYTE = 1024 * 1024;

export class SlamRecordings extends SlamElement {
  static override styles = css`
    ul { list-style: none; margin: 0; padding: 0; display: grid; gap: 8px; font-size: 13px; }
    li { display: grid; grid-template-columns: 1fr auto; gap: 2px 8px; align-items: center; overflow-wrap: anywhere; }
    small { color: var(--muted); line-height: 1.4; }
    p { margin: 0 0 10px; font-size: 13px; line-height: 1.45; overflow-wrap: anywhere; }
    @media (pointer: coarse) { button { min-height: 44px; } }
  `;

  protected override readonly topics = [] as const;
  #list: List | null = null;
  #words = "Asking the bridge…";
  #fetching = "";

  override connectedCallback(): void {
    super.connectedCallback();
    void this.look();
  }

  async look(): Promise<void> {
    try {
      const answer = await fetch("recordings.json", { cache: "no-store" });
      if (answer.ok) this.#list = (await answer.json()) as List;
      else this.#words = answer.status === 404 ? "This bridge keeps its recordings in its own folder, and shows them to nobody. With [storage] in its settings it stores them elsewhere, too, and lists them here." : await answer.text();
    } catch {
      this.#words = "The bridge does not answer.";
    }
    this.requestUpdate();
  }

  override render(): TemplateResult {
    const list = this.#list;
    if (!list) return html`<p role="status">${this.#words}</p>`;
    return html`
      <p>Stored in ${list.store}. <button data-testid="recordings-look" @click=${() => this.look()}>Look again</button></p>
      ${list.fault ? html`<p role="alert" data-testid="recordings-fault">${list.fault}</p>` : nothing}
      <ul aria-label="Recordings" data-testid="recordings">${list.recordings.slice(0, MOST).map((one) => html`<li>
        <span>${one.name}<br><small>${fixed(one.bytes / MEBIBYTE, 1)} MiB · ${words(one)}</small></span>
        <button ?disabled=${one.current || this.#fetching !== ""} @click=${() => this.#open(one.name)}>${this.#fetching === one.name ? "Fetching…" : "Open"}</button>
      </li>`)}</ul>
      ${list.recordings.length > MOST ? html`<p>And ${list.recordings.length - MOST} older ones.</p>` : nothing}`;
  }

  async #open(name: string): Promise<void> {
    this.#fetching = name;
    this.requestUpdate();
    try {
      const answer = await fetch(`recordings/${encodeURIComponent(name)}`);
      if (answer.ok) await this.client.files.openAll([new File([await answer.blob()], name)]);
      else this.store.set("toast", { toast: { level: "warn", text: await answer.text() } });
    } catch {
      this.store.set("toast", { toast: { level: "warn", text: t`${name} did not come: the bridge does not answer.` } });
    }
    this.#fetching = "";
    this.requestUpdate();
  }
}

function words({ here, stored, current, part }: Recording): string {
  if (current) return "is being written";
  if (stored) return here ? "here and stored" : word("stored");
  return part > 0 ? t`${Math.floor(100 * part)} % of it stored` : "not stored yet";
}

customElements.define("slam-recordings", SlamRecordings);
