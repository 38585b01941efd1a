// Parameters of a recorded or live robot, fitted to its drive, with standard errors and as a
// preset; and the twin.

import { css, type TemplateResult } from "lit";
import type { DriveFit, SettingValues } from "../protocol/module.js";
import type { Column } from "../csv.js";
import { html, t } from "../words.js";
import "./csv_button.js";
import { SlamElement } from "./element.js";
import { isChecked } from "./input.js";
import { tool } from "./style.js";

export class SlamFit extends SlamElement {
  static override styles = [
    tool,
    css`
      .row { display: flex; flex-wrap: wrap; gap: 8px; margin: 8px 0; }
      .row > * { flex: 1 1 130px; }
      table { width: 100%; border-collapse: collapse; font-size: 12.5px; margin: 4px 0 8px; }
      th { text-align: left; font-weight: 500; color: var(--muted); padding: 3px 0; }
      td, tbody th { border-top: 1px solid color-mix(in srgb, var(--line) 60%, transparent); padding: 5px 0; vertical-align: top; }
      tbody th { color: var(--ink); padding-right: 8px; line-height: 1.35; }
      td, th + th { text-align: right; white-space: nowrap; }
      small { display: block; color: var(--muted); font-size: 11.5px; }
      label.twin { display: flex; gap: 9px; align-items: center; min-height: 40px; font-size: 13px; cursor: pointer; }
      label.twin input { width: 18px; height: 18px; accent-color: var(--accent); flex: none; }
    `,
  ];

  protected override readonly topics = ["fit", "run", "settings"] as const;

  override render(): TemplateResult {
    const { store } = this;
    this.toggleAttribute("hidden", store.source === "sim");
    const { fit, error } = store.fit;
    const used = store.tuning.preset;
    return html`<details data-testid="fit">
      <summary>Fit the robot to this drive</summary>
      <p>What the wheels counted is compared with the poses of this map: how far each track really runs, how wide apart they act, and how much of it is chance. Drive some metres straight on and turn to both sides; scan matching gives the best poses.</p>
      <div class="row"><button data-testid="fit-drive" @click=${() => this.client.send({ kind: "fit" })}>Fit from this drive</button></div>
      <div aria-live="polite">${error ? html`<p class="bad" role="alert" data-testid="fit-error">${error}</p>` : fit ? this.#table(fit) : ""}</div>
      ${used ? html`<p data-testid="fit-used">In use: ${used.name}. <button @click=${() => this.client.usePreset(null)} data-testid="fit-drop">Stop using it</button></p>` : ""}
      <label class="twin"><input type="checkbox" data-testid="twin" .checked=${store.tuning.twin} @change=${(e: Event) => this.client.setTwin(isChecked(e))}>
        <span>Run a simulated twin beside it<small>${used ? "With the figures of the preset." : "With the figures of the robot's model."} The curves are among the plots.</small></span></label>
    </details>`;
  }

  #table(fit: DriveFit): TemplateResult {
    const known = Object.keys(fit.settings).length > 0;
    return html`
      ${fit.reasons.map((reason) => html`<p class="bad" data-testid="fit-reason">${reason}.</p>`)}
      ${fit.parameters.length === 0 ? "" : html`<table data-testid="fit-table">
        <thead><tr><th scope="col">Parameter</th><th scope="col">Value ± σ</th></tr></thead>
        <tbody>${fit.parameters.map((p) => html`<tr><th scope="row">${p.name}${Number.isFinite(p.model) && p.model !== 0 ? html`<small>model: ${short(p.model, p.model)}${p.unit && ` ${p.unit}`}</small>` : ""}${p.unknown ? html`<small>${p.unknown}</small>` : ""}</th>
          ${p.unknown ? html`<td>unknown</td>` : html`<td class="num">${short(p.value, p.sigma)}${Number.isFinite(p.sigma) ? ` ± ${short(p.sigma, p.sigma)}` : ""}<small>${p.unit}</small></td>`}</tr>`)}</tbody>
      </table>
      <slam-csv .name=${"drive-fit"} .columns=${() => columnsOf(fit)}></slam-csv>
      <p>${fit.legs} legs were used${fit.leftOut > 0 ? html`; ${fit.leftOut} could not be explained and were left out: a push, or tracks that spun` : ""}.</p>`}
      ${known ? html`<div class="row">
        <button data-testid="fit-use" @click=${() => this.client.usePreset({ name: t`fit of ${this.store.title}`, settings: fit.settings as SettingValues })}>Use as preset</button>
        <button data-testid="fit-save" @click=${() => this.client.send({ kind: "save", what: "fit" })}>Save as a file</button>
      </div>` : ""}`;
  }
}

function columnsOf({ parameters }: DriveFit): Column[] {
  return [
    { title: "Parameter", unit: "", values: parameters.map(({ name }) => name) }, { title: "Unit", unit: "", values: parameters.map(({ unit }) => unit) },
    { title: "Value", unit: "", values: parameters.map(({ value, unknown }) => (unknown ? NaN : value)) }, { title: "σ", unit: "", values: parameters.map(({ sigma, unknown }) => (unknown ? NaN : sigma)) },
    { title: "Value of the model", unit: "", values: parameters.map(({ model }) => model) },
  ];
}

/** Rounded to the second significant digit of the standard error. */
function short(value: number, sigma: number): string {
  const size = Math.abs(Number.isFinite(sigma) && sigma !== 0 ? sigma : value);
  if (!(size > 0)) return "0";
  const digits = 1 - Math.floor(Math.log10(size));
  return digits > 7 ? value.toExponential(1) : value.toFixed(Math.max(0, digits));
}

customElements.define("slam-fit", SlamFit);
