// The registration lab: two clouds, all methods side by side, and a map of starts. It lies over the
// map, and its code is loaded when it is first opened.

import { css, LitElement, nothing, type TemplateResult } from "lit";
import type { Keyframe, Keyframes } from "../keyframes.js";
import type { Column } from "../csv.js";
import type { MeasuredRow, RegistrationOffer } from "../protocol/module.js";
import type { Store } from "../store.js";
import "../ui/csv_button.js";
import { DASH, fixed, percent } from "../ui/format.js";
import { icons } from "../ui/icons.js";
import { filesOf, valueOf } from "../ui/input.js";
import { shared } from "../ui/style.js";
import { takeDrops } from "../ui/own_drops.js";
import { html, t } from "../words.js";
import "./basin_view.js";
import "./clouds_view.js";
import "./method_card.js";
import { wordsOf } from "./methods.js";
import { LabModel } from "./model.js";
import { between, NOWHERE, takeBack } from "./pose.js";
import type { Role } from "./protocol.js";

/** Largest offset of a random start, m and rad: the range that was measured. */
const RANDOM = { shift: 1, turn: Math.PI / 4 } as const;

export class SlamRegistration extends LitElement {
  static override styles = [
    shared,
    css`
      :host { position: fixed; inset: 56px 0 0; z-index: 20; background: var(--page); outline: none; overflow-y: auto; overflow-x: hidden; scrollbar-width: thin; scrollbar-color: var(--line-strong) transparent; }
      .page { max-width: 1720px; margin: 0 auto; padding: 12px 18px 28px; display: grid; grid-template-columns: minmax(0, 1fr); gap: 12px; }
      .head { display: flex; align-items: center; gap: 14px; }
      .head h2 { font: 620 20px/1.2 var(--sans); letter-spacing: -.02em; text-transform: none; color: var(--ink); white-space: nowrap; }
      .head p { flex: 1; margin: 0; color: var(--muted); font-size: 13.5px; min-width: 0; }
      .sources { display: flex; flex-wrap: wrap; gap: 7px; align-items: center; }
      .sources button[aria-pressed="true"] { border-color: var(--accent); box-shadow: inset 0 0 0 1px var(--accent); }
      .sources .button, .sources button { min-height: 34px; font-size: 13px; }
      .file { position: relative; }
      .tray { display: flex; flex-wrap: wrap; gap: 8px; align-items: end; padding: 10px 12px; border: 1px solid var(--line); border-radius: 12px; background: var(--surface); font-size: 13px; }
      .tray label.pick { display: grid; gap: 3px; font-size: 12px; color: var(--muted); min-width: 200px; }
      .tray select { color: var(--ink); }
      .tray p { margin: 0; align-self: center; color: var(--muted); flex: 1 1 220px; line-height: 1.4; }
      .check { display: flex; align-items: center; gap: 8px; min-height: 36px; }
      .check input { width: 16px; height: 16px; accent-color: var(--accent); }
      .tray button[aria-pressed="true"] { background: var(--accent); color: var(--on-accent); border-color: transparent; }
      .bad { margin: 0; padding: 9px 12px; border-radius: 10px; border: 1px solid var(--warn); color: var(--warn-ink); background: var(--surface); font-size: 13.5px; }
      .said:empty { display: none; }
      .note { margin: 0; font-size: 12.5px; color: var(--muted); }
      .top { display: grid; grid-template-columns: minmax(0, 1.75fr) minmax(330px, 1fr); gap: 12px; height: clamp(420px, 56vh, 640px); }
      .left { display: flex; flex-direction: column; gap: 8px; min-height: 0; min-width: 0; }
      lab-clouds { flex: 1; min-height: 0; }
      .start { display: flex; flex-wrap: wrap; gap: 8px 14px; align-items: center; font-size: 13px; }
      .start .num { font-size: 12.5px; white-space: nowrap; }
      .start button { min-height: 34px; font-size: 13px; }
      .start .grow { flex: 1; }
      .advice { margin: 0; padding: 10px 14px; border: 1px solid var(--line); border-left: 4px solid var(--accent); border-radius: 10px; background: var(--surface); font-size: 13.5px; line-height: 1.5; min-height: 63px; }
      .advice b { font-weight: 620; }
      .time { position: sticky; top: 0; z-index: 2; display: flex; align-items: center; gap: 10px; padding: 8px 12px; border: 1px solid var(--line); border-radius: 12px; background: var(--surface); box-shadow: var(--shadow); }
      .time input { flex: 1; min-width: 60px; accent-color: var(--accent); min-height: 36px; }
      .time .num { font-size: 12.5px; white-space: nowrap; min-width: 13ch; text-align: right; }
      .cards { display: grid; grid-template-columns: repeat(auto-fill, minmax(310px, 1fr)); gap: 12px; }
      details { border: 1px solid var(--line); border-radius: 12px; background: var(--surface); padding: 2px 14px; }
      .scroll { overflow-x: auto; padding-bottom: 12px; }
      table { border-collapse: collapse; font-size: 12.5px; width: 100%; }
      th { font-weight: 500; color: var(--muted); text-align: right; padding: 4px 10px; white-space: nowrap; }
      th:first-child, td:first-child { text-align: left; padding-left: 0; white-space: nowrap; }
      td { text-align: right; padding: 4px 10px; border-top: 1px solid var(--line); font-family: var(--mono); font-variant-numeric: tabular-nums; white-space: nowrap; }
      td:first-child { font-family: var(--sans); }
      @media (pointer: coarse) { .sources button, .start button, .tray button, .tray .button { min-height: 44px; } }
      @media (max-width: 900px) {
        /* One below the other; the map of starts comes after what it explains. */
        .top { display: contents; }
        lab-clouds { flex: none; height: min(46vh, 420px); }
        lab-basin { height: 520px; order: 1; }
        details { order: 2; }
      }
      @media (max-width: 760px) {
        :host { inset: 54px 0 0; }
        .page { padding: 10px 10px 24px; gap: 10px; }
        .head p { display: none; }
        .head h2 { flex: 1; }
        .sources { flex-wrap: nowrap; overflow-x: auto; margin: 0 -10px; padding: 2px 10px; scrollbar-width: none; }
        .sources > * { flex: none; }
        .cards { grid-template-columns: minmax(0, 1fr); }
        .time .num { min-width: 11ch; }
      }
    `,
  ];

  /** Set by the creator of the element. */
  store!: Store;
  keyframes!: Keyframes;
  onClose: () => void = () => {};
  readonly #model = new LabModel();
  #leave: (() => void) | null = null;
  #isScan = true;

  override connectedCallback(): void {
    super.connectedCallback();
    this.setAttribute("role", "dialog");
    this.setAttribute("aria-label", t("Registration lab"));
    this.tabIndex = -1;
    this.#leave = this.#model.on(() => this.requestUpdate());
    this.store.on("theme", () => {
      // The canvases read their colours again.
      for (const each of this.renderRoot.querySelectorAll("lab-clouds, lab-method, lab-basin")) (each as LitElement).requestUpdate();
    });
    this.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      event.preventDefault();
      this.onClose();
    });
    takeDrops(this, (files) => this.#openAll(files));
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.#leave?.();
  }

  /** Stops all work while the lab is hidden. */
  rest(): void {
    this.#model.rest();
  }

  override render(): TemplateResult {
    const model = this.#model;
    const { offer, error, note } = model;
    return html`<div class="page">
      <div class="head"><h2>Registration lab</h2><p>Two scans of one place: how does one lie on the other? Drag the orange one, and every method looks for the way from there.</p>
        <button data-testid="lab-close" title="Close (Esc)" @click=${() => this.onClose()}>${icons.close} Close</button></div>
      <div class="sources" role="group" aria-label="Which clouds">
        ${(offer?.pairs ?? []).map(({ name, title }) => html`<button data-testid="lab-pair-${name}" aria-pressed=${model.pair === name} @click=${() => model.choose(name)}>${title}</button>`)}
        <button data-testid="lab-pair-run" aria-pressed=${model.pair === "run"} @click=${() => this.#takeRun(-1, 0)}>This run</button>
        <button data-testid="lab-pair-files" aria-pressed=${model.pair === "files"} @click=${() => this.#empty("files", "Files")}>Files</button>
        <button data-testid="lab-pair-drawn" aria-pressed=${model.pair === "drawn"} @click=${() => this.#empty("drawn", "Drawn")}>${icons.pencil} Draw</button>
      </div>
      ${this.#tray()}
      <div class="said" aria-live="polite">${error ? html`<p class="bad" role="alert" data-testid="lab-error">${error}</p>` : nothing}</div>
      ${note ? html`<p class="note" data-testid="lab-note">${note}</p>` : nothing}
      <div class="top">
        <div class="left">
          <lab-clouds .model=${model}></lab-clouds>
          ${this.#startRow()}
          ${this.#advice()}
        </div>
        <lab-basin .model=${model}></lab-basin>
      </div>
      ${this.#time()}
      <div class="cards">${(offer?.methods ?? []).map((name) => html`<lab-method data-testid="lab-method-${name}" .model=${model} .name=${name}></lab-method>`)}</div>
      ${this.#table()}
    </div>`;
  }

  #startRow(): TemplateResult {
    const model = this.#model;
    const [x, y, heading] = model.start;
    const { right, clouds } = model;
    return html`<div class="start">
      <span class="num" data-testid="lab-start">x ${fixed(x, 2)} m · y ${fixed(y, 2)} m · ${fixed((180 / Math.PI) * heading, 1)}°</span>
      <span class="grow"></span>
      <button data-testid="lab-reset" title="To where both sensors stand on each other (Home)" @click=${() => model.move(NOWHERE)}>${icons.again} Reset</button>
      <button data-testid="lab-random" title="Up to ${RANDOM.shift} m and 45° off the right pose" ?disabled=${!right} @click=${() => this.#random()}>${icons.dice} Random start</button>
      <button data-testid="lab-truth" title=${clouds.truth ? clouds.truthWords : "Of the best verdict"} ?disabled=${!right} @click=${() => right && model.move(right)}>${icons.pin} ${clouds.truth ? "True pose" : "Best pose"}</button>
    </div>`;
  }

  #advice(): TemplateResult {
    const { advice, clouds, shown } = this.#model;
    if (!advice) {
      const why = clouds.fixed.length === 0 || clouds.moving.length === 0 ? "Two clouds are needed." : shown.size === 0 ? "Choose a method below." : this.#model.running ? "…" : "No method found a pose to judge these clouds by: drag the orange one nearer.";
      return html`<p class="advice" data-testid="lab-advice">${why}</p>`;
    }
    const { method, surest, fastest, condition, isNear, overlap, sigma, scatter } = advice;
    const name = (each: { name: string }): TemplateResult => html`<b>${wordsOf(each.name).title}</b>`;
    const found = (each: { found: number }): string => percent(each.found);
    return html`<p class="advice" data-testid="lab-advice" data-method=${method.name}>Take ${name(method)}. These are most like ${condition} (${percent(overlap)} of the points on a surface, σ ${fixed(1000 * sigma, 0)} mm, ${percent(scatter)} on none), from a ${isNear ? "near" : "far"} start. There it found ${found(method)} of ${this.#model.offer?.measured_pairs ?? DASH} measured pairs in ${micros(method.micros)}${method.name === surest.name ? ", the most of all" : html`; ${name(surest)} ${found(surest)} in ${micros(surest.micros)}`}${method.name === fastest.name ? ", and it is the fastest" : html`; the fastest, ${name(fastest)}, ${found(fastest)} in ${micros(fastest.micros)}`}.${this.#blind}</p>`;
  }

  /** A problem that no method can solve. */
  get #blind(): string {
    const { found } = this.#model;
    const isBlind = found.some(({ verdict }) => verdict === "degenerate") && !found.some(({ verdict }) => verdict === "converged");
    return isBlind ? " But how far along the red arrow, none can know: these walls do not tell." : "";
  }

  #time(): TemplateResult {
    const model = this.#model;
    const { step, lastStep, playing } = model;
    return html`<div class="time" role="group" aria-label="Iterations">
      <button class="icon" data-testid="lab-play" ?disabled=${lastStep === 0} aria-label=${playing ? "Pause" : "Play the iterations"} title=${playing ? "Pause" : "Play"} @click=${() => model.play(!playing)}>${playing ? icons.pause : icons.play}</button>
      <button class="icon" data-testid="lab-step" ?disabled=${step >= lastStep} aria-label="Next iteration" title="Next iteration" @click=${() => model.show(step + 1)}>${icons.step}</button>
      <input type="range" data-testid="lab-slider" min="0" max=${lastStep} step="1" .value=${String(step)} aria-label="Iteration" aria-valuetext=${step >= lastStep ? "end" : t`iteration ${step + 1}`} @input=${(e: Event) => { model.play(false); model.show(Number(valueOf(e))); }}>
      <span class="num">${lastStep === 0 ? DASH : step >= lastStep ? "end" : t`iteration ${step + 1}`}</span>
    </div>`;
  }

  #tray(): TemplateResult | typeof nothing {
    const model = this.#model;
    if (model.pair === "run") return this.#runTray();
    if (model.pair === "files") {
      const file = (role: Role): TemplateResult => html`<label class="file"><input type="file" data-testid="lab-file-${role}" accept=".csv,.txt,.xy,text/*" @change=${(e: Event) => this.#openAll(filesOf(e), role)}><span class="button">${icons.open} ${role === "fixed" ? "Fixed" : "Moving"} cloud…</span></label>`;
      return html`<div class="tray">${file("fixed")}${file("moving")}
        <label class="check"><input type="checkbox" data-testid="lab-is-scan" .checked=${this.#isScan} @change=${() => { this.#isScan = !this.#isScan; model.setClouds({ ...model.clouds, areScans: this.#isScan }, model.start); }}>A sensor stood at the origin</label>
        <p>A line of x and y in metres for each point. Two files can be dropped here at once.</p></div>`;
    }
    if (model.pair !== "drawn") return nothing;
    const { pen, clouds } = model;
    const draw = (role: Role): TemplateResult => html`<button data-testid="lab-pen-${role}" aria-pressed=${pen === role} @click=${() => model.setPen(pen === role ? null : role)}>${icons.pencil} ${role === "fixed" ? "Fixed" : "Moving"}</button>`;
    return html`<div class="tray">${draw("fixed")}${draw("moving")}
      <button data-testid="lab-copy" ?disabled=${clouds.fixed.length === 0} @click=${() => { model.setPen(null); model.setClouds({ ...clouds, moving: clouds.fixed.slice() }, [0.4, 0.25, 0.35]); }}>Moving as fixed</button>
      <button data-testid="lab-clear" @click=${() => this.#empty("drawn", "Drawn")}>Clear</button>
      <p>${pen ? "Choose the pen again to lay it down, and drag the orange cloud." : "Choose a pen and draw walls, or copy one cloud to the other."}</p></div>`;
  }

  #runTray(): TemplateResult {
    const { all } = this.keyframes;
    const pick = (role: Role, chosen: number): TemplateResult => html`<label class="pick">${role === "fixed" ? "Fixed scan" : "Moving scan"}<select data-testid="lab-keyframe-${role}" @change=${(e: Event) => { const at = Number(valueOf(e)); this.#takeRun(role === "moving" ? at : this.#chosen.moving, role === "fixed" ? at : this.#chosen.fixed); }}>
      ${all.map(({ time, pose: [x, y] }, i) => html`<option value=${i} .selected=${i === chosen}>at ${fixed(time, 1)} s, ${fixed(x, 1)}, ${fixed(y, 1)} m</option>`)}
    </select></label>`;
    return html`<div class="tray">${pick("fixed", this.#chosen.fixed)}${pick("moving", this.#chosen.moving)}<p>Scans of the run behind this page, one for each half metre of the way. The pose that counts as right is the map's.</p></div>`;
  }

  #chosen: Record<Role, number> = { fixed: 0, moving: 0 };

  /** Takes two scans of the run; negative indices count from the newest. */
  #takeRun(moving: number, fixed: number): void {
    const model = this.#model;
    const { all } = this.keyframes;
    if (all.length < 2) return model.say("This run has not yet two scans half a metre apart: let the robot move on, then come back.");
    const last = all.length - 1;
    const movingAt = moving < 0 ? last : moving;
    // At first, one that is not far from it.
    const fixedAt = moving < 0 ? Math.max(0, last - 2) : fixed;
    const [a, b] = [all[fixedAt], all[movingAt]];
    if (!a || !b) return;
    this.#chosen = { fixed: fixedAt, moving: movingAt };
    model.pair = "run";
    model.setPen(null);
    model.setClouds({ title: this.store.title, fixed: own(a), moving: own(b), truth: between(a.pose, b.pose), truthWords: "as the map has it", areScans: true }, NOWHERE);
  }

  /** Starts without clouds, to be filled from files or by hand. */
  #empty(pair: "files" | "drawn", title: string): void {
    const model = this.#model;
    const none = new Float64Array(0);
    model.pair = pair;
    model.setPen(pair === "drawn" ? "fixed" : null);
    model.setClouds({ title, fixed: none, moving: none, truth: null, truthWords: "", areScans: pair === "files" && this.#isScan }, NOWHERE);
  }

  /** One file for a cloud, or two for both. */
  #openAll(files: readonly File[], role: Role = "fixed"): void {
    const [first, second] = files;
    if (!first) return;
    if (second) {
      this.#model.open(first, "fixed");
      this.#model.open(second, "moving");
    } else this.#model.open(first, role);
  }

  #random(): void {
    const { right } = this.#model;
    if (!right) return;
    const [way, direction] = [RANDOM.shift * Math.sqrt(Math.random()), 2 * Math.PI * Math.random()];
    this.#model.move([right[0] + way * Math.cos(direction), right[1] + way * Math.sin(direction), right[2] + RANDOM.turn * (2 * Math.random() - 1)]);
  }

  #table(): TemplateResult | typeof nothing {
    const { offer } = this.#model;
    if (!offer) return nothing;
    const conditions = [...new Map(offer.measured.map(({ condition, title }) => [condition, title]))];
    const cell = (condition: string, method: string): string => {
      const row = offer.measured.find((each) => each.condition === condition && each.method === method);
      return row ? `${percent(row.found[0])} · ${percent(row.found[1])} · ${micros(row.micros)}` : DASH;
    };
    return html`<details data-testid="lab-table"><summary>What the advice rests on: ${offer.measured_pairs} pairs measured under each condition</summary>
      <p class="note">Part found from starts up to 1 m and 45° off, part found from starts within 0.5 m and 15°, and the median time in the native core.</p>
      <div class="scroll"><table><thead><tr><th scope="col">Method</th>${conditions.map(([, title]) => html`<th scope="col">${title}</th>`)}</tr></thead>
      <tbody>${offer.methods.map((method) => html`<tr><td>${wordsOf(method).title}</td>${conditions.map(([condition]) => html`<td>${cell(condition, method)}</td>`)}</tr>`)}</tbody></table></div>
      <slam-csv .name=${"registration-measured"} .columns=${() => measuredOf(offer)}></slam-csv>
    </details>`;
  }
}

function measuredOf({ measured }: RegistrationOffer): Column[] {
  const numbers = (title: string, unit: string, value: (row: MeasuredRow) => number): Column => ({ title, unit, values: measured.map(value) });
  return [
    { title: "Condition", unit: "", values: measured.map(({ title }) => title) }, { title: "Method", unit: "", values: measured.map(({ method }) => wordsOf(method).title) },
    numbers("Found, far starts", "", ({ found }) => found[0]), numbers("Found, near starts", "", ({ found }) => found[1]), numbers("Time, median", "s", ({ micros }) => micros / 1e6),
  ];
}

/** A scan in the frame of the robot that took it. */
function own({ pose, hits }: Keyframe): Float64Array {
  const points = new Float64Array(hits.length);
  for (let i = 0; i + 1 < hits.length; i += 2) [points[i], points[i + 1]] = takeBack(pose, hits[i] ?? 0, hits[i + 1] ?? 0);
  return points;
}

function micros(micros: number): string {
  return micros < 1000 ? `${fixed(micros, 0)} µs` : `${fixed(micros / 1000, 1)} ms`;
}

customElements.define("slam-registration", SlamRegistration);
