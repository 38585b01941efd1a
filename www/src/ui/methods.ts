// Methods side by side on one log: the figures of each that was run on it, and the distance of its
// trajectory from the one that is shown.

import { css, nothing, type TemplateResult } from "lit";
import { apart, type Compared, shownRun } from "../compared.js";
import type { Column } from "../csv.js";
import { needsPriorMap } from "../protocol/methods.js";
import type { MethodInfo } from "../protocol/module.js";
import { word } from "../spoken.js";
import { methodPen } from "../view/layers/compared.js";
import { html, svg, t } from "../words.js";
import "./csv_button.js";
import { SlamElement } from "./element.js";
import { DASH, fixed } from "./format.js";

export class SlamMethods extends SlamElement {
  static override styles = css`
    h2 { margin: 18px 0 8px; }
    p { margin: 0 0 8px; font-size: 12.5px; color: var(--muted); }
    table { width: 100%; border-collapse: collapse; font-size: 12px; }
    th { font: 500 11px/1.2 var(--sans); color: var(--muted); text-align: right; padding: 0 0 5px 6px; white-space: nowrap; }
    td { padding: 0 0 0 6px; height: 34px; text-align: right; font: 500 11.5px/1.2 var(--mono); font-variant-numeric: tabular-nums; white-space: nowrap; border-top: 1px solid var(--line); letter-spacing: -.02em; }
    th:first-child, td:first-child { text-align: left; padding-left: 0; }
    td:first-child { font: 500 12.5px/1.2 var(--sans); letter-spacing: 0; }
    td span { display: flex; align-items: center; gap: 7px; }
    svg { width: 26px; height: 8px; }
    .shown td { background: var(--sunk); }
    .shown td:first-child { font-weight: 650; }
    td button { min-height: 28px; padding: 0 8px; font: 500 12px/1 var(--sans); }
    @media (pointer: coarse) { td button { min-height: 40px; } td { height: 46px; } }
  `;

  protected override readonly topics = ["frame", "run"] as const;

  override render(): TemplateResult | typeof nothing {
    const { store, scene } = this;
    const shown = store.source === "replay" ? shownRun(store, scene) : null;
    if (!shown) return nothing;
    const methods = store.offer.methods.filter(({ name }) => !needsPriorMap(name) || store.setup.priorMap || name === store.method);
    return html`
      <h2 id="methods">Methods, side by side</h2>
      <p>Each maps the same log from its beginning; the ways of those that were left are laid over the map.</p>
      <table aria-labelledby="methods" data-testid="methods">
        <thead><tr><th scope="col">Method</th><th scope="col" title="Median of what a scan cost">ms</th><th scope="col" title="Loop closures accepted">loops</th><th scope="col" title="How far its way is from the one that is shown, at the same times: root mean square">apart</th><th></th></tr></thead>
        <tbody>${methods.map((method) => this.#row(method, shown))}</tbody>
      </table>
      <slam-csv .name=${"methods"} .columns=${() => columnsOf([shown, ...this.store.compared], shown)}></slam-csv>`;
  }

  #row({ name, title, meaning }: MethodInfo, shown: Compared): TemplateResult {
    const isShown = name === shown.method;
    const run = isShown ? shown : this.store.compared.find((run) => run.method === name);
    const { colour, dash } = methodPen(run?.place ?? 0);
    const sign = isShown ? svg`<path d="M1 4h24" stroke="var(--map-estimate)" stroke-width="2.5"/>` : svg`<path d="M1 4h24" stroke="var(--map-${colour})" stroke-width="2.5" stroke-dasharray=${dash.join(" ")}/>`;
    const gap = run && !isShown ? apart(shown.trail, run.trail) : null;
    const part = run && run.progress < 1 ? t`${fixed(100 * run.progress, 0)} % of the log` : "the whole log";
    return html`<tr class=${isShown ? "shown" : ""} data-testid="method-${name}" title=${run ? t`${meaning}. ${run.scans} scans, ${part}` : meaning}>
      <td><span>${run ? html`<svg viewBox="0 0 26 8" aria-hidden="true">${sign}</svg>` : nothing}${title}</span></td>
      <td>${run ? fixed(run.scanMillis, 1) : DASH}</td>
      <td>${run ? run.loopClosures : DASH}</td>
      <td title=${gap ? t`at most ${fixed(gap.most, 2)} m` : ""} data-testid="apart-${name}">${gap ? `${fixed(gap.rms, 2)} m` : isShown ? word("shown") : DASH}</td>
      <td>${isShown ? nothing : html`<button data-testid="run-${name}" @click=${() => this.client.again(name)}>${run ? "Again" : "Run"}</button>`}</td></tr>`;
  }
}

/** The figures of the methods that were run. */
function columnsOf(runs: readonly Compared[], shown: Compared): Column[] {
  const numbers = (title: string, unit: string, value: (run: Compared) => number): Column => ({ title, unit, values: runs.map(value) });
  const gap = (run: Compared): { rms: number; most: number } => (run === shown ? { rms: 0, most: 0 } : apart(shown.trail, run.trail));
  return [
    { title: "Method", unit: "", values: runs.map(({ method }) => method) }, numbers("Part of the log", "", ({ progress }) => progress), numbers("Scans", "", ({ scans }) => scans),
    numbers("Time per scan, median", "ms", ({ scanMillis }) => scanMillis), numbers("Loop closures", "", ({ loopClosures }) => loopClosures),
    numbers("Apart from the one shown, RMS", "m", (run) => gap(run).rms), numbers("Apart from the one shown, most", "m", (run) => gap(run).most),
  ];
}

customElements.define("slam-methods", SlamMethods);
