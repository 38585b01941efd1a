// A button below each plot or table of figures that saves its data.

import { css, LitElement, type TemplateResult } from "lit";
import { type Column, csvOf } from "../csv.js";
import { download } from "../save.js";
import { html, t } from "../words.js";
import { icons } from "./icons.js";
import { shared } from "./style.js";

export class SlamCsv extends LitElement {
  static override styles = [shared, css`
    :host { display: inline-block; margin-bottom: 8px; }
    button { min-height: 32px; padding: 2px 10px; font-size: 12.5px; }
    @media (pointer: coarse) { button { min-height: 44px; } }
  `];

  /** File name without extension; it also identifies the button. */
  name = "";
  /** The data of the file: the exact numbers, not those as drawn. */
  columns: () => readonly Column[] = () => [];

  override render(): TemplateResult {
    return html`<button data-testid="csv-${this.name}" title="Save these figures as a table: CSV with units" @click=${() => this.#save()}>${icons.save} CSV</button>`;
  }

  #save(): void {
    download(new Blob([csvOf(this.columns().map((column) => ({ ...column, title: t(column.title) })))], { type: "text/csv;charset=utf-8" }), `${this.name}.csv`);
  }
}

// Each bundle that has such buttons contains this file: the first one defines the element for all.
if (!customElements.get("slam-csv")) customElements.define("slam-csv", SlamCsv);
