// One method at work: the clouds at an iteration, with the pull and the search range; the result in
// words and figures; and the formula.

import { css, nothing, type PropertyDeclarations, type TemplateResult } from "lit";
import { fixed, length, percent } from "../ui/format.js";
import { Camera, union } from "../view/camera.js";
import { html, t } from "../words.js";
import { boxOf, coloursOf, drawCloud, drawDirection, drawEllipse, drawPulls, drawRules, drawWidths, prepare } from "./draw.js";
import { LabElement } from "./element.js";
import { wordsOf } from "./methods.js";
import { errorOf, figureAt, iterations, poseAt } from "./model.js";
import type { Found } from "./protocol.js";

export class LabMethod extends LabElement {
  static override properties: PropertyDeclarations = { name: { attribute: false } };
  declare name: string;

  static override styles = css`
    :host { display: flex; flex-direction: column; border: 1px solid var(--line); border-radius: 14px; background: var(--raised); overflow: hidden; }
    :host([advised]) { border-color: var(--accent); box-shadow: inset 0 0 0 1px var(--accent); }
    .title { display: flex; align-items: center; gap: 9px; padding: 4px 12px 0; min-height: 44px; }
    label { display: flex; align-items: center; gap: 9px; flex: 1; min-width: 0; font-weight: 600; font-size: 14px; cursor: pointer; min-height: 40px; }
    input { width: 17px; height: 17px; flex: none; accent-color: var(--accent); margin: 0; }
    .tag { font-size: 11px; font-weight: 600; color: var(--accent-ink); border: 1px solid currentColor; border-radius: 99px; padding: 1px 8px; flex: none; }
    .picture { position: relative; height: 190px; background: var(--map-free); border-block: 1px solid var(--line); }
    canvas { position: absolute; inset: 0; width: 100%; height: 100%; }
    .off { position: absolute; inset: 0; display: grid; place-content: center; color: var(--muted); font-size: 13px; background: var(--sunk); }
    .note { position: absolute; right: 8px; bottom: 6px; font-size: 11px; color: var(--ink); background: var(--glass); padding: 1px 7px; border-radius: 6px; }
    .at { position: absolute; left: 8px; top: 6px; font: 500 11px/1.5 var(--mono); background: var(--glass); padding: 1px 7px; border-radius: 6px; }
    .body { padding: 10px 12px 12px; display: flex; flex-direction: column; gap: 8px; flex: 1; }
    .verdict { margin: 0; font-size: 13px; line-height: 1.4; min-height: 2.8em; display: flex; gap: 8px; }
    .verdict::before { content: ""; width: 9px; height: 9px; margin-top: 5px; border-radius: 50%; flex: none; background: var(--muted); }
    .good::before { background: var(--good); }
    .warn::before { background: var(--warn); border-radius: 2px; }
    dl { display: grid; grid-template-columns: repeat(3, 1fr); gap: 6px 10px; margin: 0; }
    dl div { display: flex; flex-direction: column; min-width: 0; }
    dt { font-size: 11px; color: var(--muted); }
    dd { margin: 0; font: 500 12.5px/1.3 var(--mono); font-variant-numeric: tabular-nums; white-space: nowrap; }
    .formula { border-top: 1px solid var(--line); padding-top: 8px; margin-top: auto; }
    .formula p { margin: 0 0 4px; font-size: 12.5px; line-height: 1.4; color: var(--muted); }
    @media (max-width: 760px) { .verdict { min-height: 0; } }
    math { font-size: 16px; overflow-x: auto; overflow-y: hidden; padding: 3px 0; display: block math; min-height: 48px; }
    cite { display: block; font: 400 11.5px/1.4 var(--sans); color: var(--muted); text-align: right; }
  `;

  readonly #camera = new Camera();
  #formula: Element | null = null;
  #zoom = 0;

  override render(): TemplateResult {
    const { model, name } = this;
    const words = wordsOf(name);
    this.#formula ??= words.formula();
    const isShown = model.shown.has(name);
    const found = isShown ? model.found.find((each) => each.method === name) : undefined;
    const isAdvised = model.advice?.method.name === name;
    this.toggleAttribute("advised", isAdvised);
    return html`
      <div class="title"><label><input type="checkbox" data-testid="lab-run-${name}" .checked=${isShown} @change=${() => model.toggle(name)}>${words.title}</label>${isAdvised ? html`<span class="tag">advised</span>` : nothing}</div>
      <div class="picture" role="img" aria-label="${words.title}: ${found ? this.#stepWords(found) : "not run"}">
        <canvas></canvas>
        ${found ? html`<span class="at" data-testid="lab-at-${name}">${this.#stepWords(found)}</span><span class="note" data-note hidden></span>` : html`<div class="off">${isShown ? (model.running ? "running…" : "no clouds yet") : "not run"}</div>`}
      </div>
      <div class="body">
        ${found ? this.#result(found) : nothing}
        <div class="formula"><p>${words.meaning}</p>${this.#formula}<cite>${words.source}</cite></div>
      </div>`;
  }

  override updated(): void {
    const { model, name } = this;
    const found = model.found.find((each) => each.method === name);
    const canvas = this.renderRoot.querySelector("canvas");
    if (!found || !canvas || !model.shown.has(name)) return;
    const { clouds, start, step } = model;
    const [stays, moves] = [boxOf(clouds.fixed, [0, 0, 0], clouds.areScans), boxOf(clouds.moving, start, clouds.areScans)];
    if (!stays || !moves) return;
    const brush = prepare(canvas, union(stays, moves), coloursOf(this), this.#camera);
    if (!brush) return;
    const pose = poseAt(found, step);
    const isEnd = step >= iterations(found);
    drawRules(brush);
    const width = figureAt(found, step, "width");
    if (!isEnd && width > 0) drawWidths(brush, clouds.moving, pose, width, wordsOf(name).isCell ?? false);
    drawCloud(brush, clouds.fixed, [0, 0, 0], brush.colours.fixed, 1.3);
    drawPulls(brush, isEnd ? new Float32Array(0) : model.correspondences.get(name) ?? new Float32Array(0));
    drawCloud(brush, clouds.moving, pose, brush.colours.moving, 1.3);
    if (isEnd && found.direction) drawDirection(brush, pose, found.direction);
    this.#zoom = isEnd && found.verdict === "converged" ? drawEllipse(brush, found) : 0;
    const note = this.renderRoot.querySelector<HTMLElement>("[data-note]");
    if (!note) return;
    note.hidden = this.#zoom === 0 && !(isEnd && found.direction);
    note.textContent = found.direction ? "this way is not told" : t`95 % ellipse${this.#zoom > 1 ? ` × ${this.#zoom}` : ""}`;
  }

  #stepWords(found: Found): string {
    const { step } = this.model;
    const count = iterations(found);
    if (step >= count) return t`end, after ${found.iterations}`;
    const width = length(figureAt(found, step, "width"));
    const words = wordsOf(this.name);
    return t`${step + 1} / ${count} · ${step === 0 ? words.firstWidth ?? words.width : words.width} ${width.value} ${width.unit} · ${figureAt(found, step, "matched")} pairs`;
  }

  #result(found: Found): TemplateResult {
    const { right, clouds } = this.model;
    const { tone, text } = verdictWords(found);
    const error = right ? errorOf(found.pose, right) : null;
    const isEnd = this.model.step >= iterations(found);
    const residual = length(isEnd ? found.residual : figureAt(found, this.model.step, "residual"));
    const off = error ? length(error.shift) : null;
    return html`
      <p class="verdict ${tone}" data-testid="lab-verdict-${this.name}" data-verdict=${found.verdict}><span>${text}</span></p>
      <dl>
        <div><dt>overlap</dt><dd>${percent(found.overlap)}</dd></div>
        <div><dt>residual</dt><dd>${residual.value} ${residual.unit}</dd></div>
        <div><dt>time</dt><dd>${fixed(found.millis, found.millis < 10 ? 2 : 0)} ms</dd></div>
        ${error && off ? html`<div title=${clouds.truth ? t`From the pose that is right: ${clouds.truthWords}` : "From the pose of the best verdict"}><dt>${clouds.truth ? "off by" : "from best"}</dt><dd>${off.value} ${off.unit}</dd></div><div><dt>turned by</dt><dd>${fixed((180 / Math.PI) * error.turn, 2)}°</dd></div>` : nothing}
        <div><dt>iterations</dt><dd>${found.iterations}</dd></div>
      </dl>`;
  }
}

/** The words for a verdict, and whether it is good. */
export function verdictWords({ verdict, direction, agreement, iterations }: Found): { tone: "good" | "warn" | ""; text: string } {
  const degrees = direction ? Math.round(((180 / Math.PI) * Math.atan2(direction[1], direction[0]) + 180) % 180) : 0;
  switch (verdict) {
    case "converged": return { tone: "good", text: "Converged: the clouds fix the pose." };
    case "degenerate": return { tone: "warn", text: t`Degenerate: nothing tells how far along ${degrees}°. The rest is right.` };
    case "local-minimum": return { tone: "warn", text: t`Local minimum: of what could agree, only ${percent(agreement)} does.` };
    case "ambiguous": return { tone: "warn", text: "Ambiguous: another pose is as good, or may be: too little is seen by both." };
    case "too-few-points": return { tone: "warn", text: "Too few points lie on a surface." };
    case "not-converged": return { tone: "warn", text: t`Not converged: still moving after ${iterations} iterations.` };
  }
}

customElements.define("lab-method", LabMethod);
