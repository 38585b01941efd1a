// The contents of a ZIP archive that was dropped: a single thing that can be opened is opened; of
// several, a person chooses. A map is one thing: its YAML with the image that it names.
//
// A bundle of its own, because a first visit does not need it.

import { css, type TemplateResult } from "lit";
import { chosen } from "../chosen.js";
import { html, t } from "../words.js";
import { entriesOf, unpacked, ZipError } from "../zip.js";
import { dialog, SlamDialog } from "./dialog.js";
import { icons } from "./icons.js";

/** An archive with more files that may be opened is refused. */
const MOST_OFFERED = 100;

export class SlamArchive extends SlamDialog {
  static override styles = [dialog, css`
    ul { display: grid; gap: 8px; margin: 0; padding: 0; list-style: none; }
    li button { width: 100%; justify-content: start; white-space: normal; text-align: left; overflow-wrap: anywhere; }
  `];

  #name = "";
  #things: readonly (readonly File[])[] = [];
  /** A part of it is damaged, which was reported. */
  #isDamaged = false;

  async open(file: File): Promise<void> {
    this.#name = file.name;
    this.#isDamaged = false;
    try {
      this.#things = await this.#openable(file);
    } catch (error) {
      const why = error instanceof ZipError ? error.message : t`it could not be read`;
      this.store.set("toast", { toast: { level: "warn", text: t`${file.name}: this is a ZIP archive that could not be opened: ${why}` } });
      return;
    }
    const [only, ...more] = this.#things;
    if (!only && this.#isDamaged) return;
    if (!only) this.store.set("toast", { toast: { level: "warn", text: t`${file.name}: nothing in this archive can be opened here.` } });
    else if (more.length === 0) void this.client.files.openAll(only);
    else {
      this.requestUpdate();
      await this.updateComplete;
      this.show();
    }
  }

  override render(): TemplateResult {
    return html`<dialog aria-labelledby="title" data-testid="archive" @click=${(e: Event) => e.target === e.currentTarget && this.close()}>
      <header><h3 id="title">What of ${this.#name}?</h3><button class="icon" aria-label="Close" @click=${() => this.close()}>${icons.close}</button></header>
      <p>Several things in this archive can be opened. Choose one; drop the archive again for another.</p>
      <ul>${this.#things.map((files) => html`<li><button data-testid="archive-${files[0]?.name ?? ""}" @click=${() => this.#choose(files)}>${icons.open} ${files.map(({ name }) => name).join(" + ")}</button></li>`)}</ul>
    </dialog>`;
  }

  #choose(files: readonly File[]): void {
    this.close();
    void this.client.files.openAll(files);
  }

  async #openable(archive: File): Promise<(readonly File[])[]> {
    const names = (await entriesOf(archive)).map(({ name }) => name);
    if (names.length > MOST_OFFERED) throw new ZipError(t`it holds more than ${MOST_OFFERED} files`);
    const { files, damaged } = await unpacked(archive, names);
    if (damaged.length > 0) {
      const text = t`${archive.name}: damaged in the archive, and left out: ${damaged.join(", ")}`;
      this.store.note({ time: this.store.status?.time ?? 0, level: "warn", text });
      this.store.set("toast", { toast: { level: "warn", text } });
      this.#isDamaged = true;
    }
    const things: (readonly File[])[] = [];
    for (const file of files) {
      const image = /\.ya?ml$/i.test(file.name) ? await imageOf(file, files) : undefined;
      const thing = image ? [file, image] : [file];
      const { kind } = await chosen(thing);
      if (kind === "building" || kind === "file" && isKnown(file.name)) things.push(thing);
    }
    return things;
  }
}

/** A file of unknown kind counts as a recording, to be judged by content; among many files only
    those with a fitting name are offered. */
const isKnown = (name: string): boolean => /\.(?:json|url|g2o|slamlab|clf|log|csv|txt|bag|mcap|gz)$/i.test(name);

async function imageOf(yaml: File, files: readonly File[]): Promise<File | undefined> {
  const named = /^image\s*:\s*["']?(.+?)["']?\s*$/m.exec(await yaml.text())?.[1]?.replace(/^.*\//, "");
  return files.find(({ name }) => name === named);
}

customElements.define("slam-archive", SlamArchive);
