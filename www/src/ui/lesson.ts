// The lesson of the run that is shown: what goes wrong, the aim, and the progress.

import { css, nothing, type TemplateResult } from "lit";
import { addressOf, current, leave, teach } from "../lessons.js";
import type { LessonInfo, Mark, MeasureName } from "../protocol/module.js";
import { word } from "../spoken.js";
import { html } from "../words.js";
import { SlamElement } from "./element.js";
import { clock, DASH, fixed, length, percent } from "./format.js";
import { icons } from "./icons.js";
import { story } from "./story_card.js";

/** A number with its unit, by the kind of measure. */
const shown = { part: percent, metres: (value: number) => { const { value: text, unit } = length(value); return unit === "" ? text : `${text} ${unit}`; }, number: (value: number) => fixed(value, value < 100 ? 1 : 0), count: (value: number) => fixed(value, 0) };

const MEASURES: Readonly<Record<MeasureName, { title: string; kind: keyof typeof shown; meaning: string }>> = {
  "explored": { title: "Explored", kind: "part", meaning: "Part of what can be reached or seen that the map knows" },
  "trajectory-error": { title: "Error of its way", kind: "metres", meaning: "Root mean square of how far off its positions were, all along its way" },
  "position-error": { title: "Position is off by", kind: "metres", meaning: "Distance of where it believes to be from where it is" },
  "wheel-drift": { title: "Wheels alone are off by", kind: "part", meaning: "Distance of where the wheels alone put it from where it is, as a part of its way" },
  "nees": { title: "NEES", kind: "number", meaning: "Squared errors in units of what the method believes: 3 if it is honest, more if it is too sure" },
  "contacts": { title: "Contacts", kind: "count", meaning: "How often it touched something" },
};

export class SlamLesson extends SlamElement {
  static override styles = [story, css`
    small { display: block; font: 600 11.5px/1.3 var(--sans); letter-spacing: .02em; color: var(--accent); }
    ul { display: grid; gap: 2px; margin: 0 0 10px; padding: 0; list-style: none; }
    li { display: grid; grid-template-columns: 18px 1fr auto; gap: 8px; align-items: baseline; padding: 5px 0; border-top: 1px solid var(--line); }
    li:last-child { border-bottom: 1px solid var(--line); }
    li > span:first-child { font-weight: 700; color: var(--muted); }
    li.met > span:first-child { color: var(--good); }
    li.missed > span:first-child { color: var(--warn); }
    li b { font: 500 14px/1.2 var(--mono); white-space: nowrap; }
    li i { margin-left: 4px; font: 400 12.5px/1.2 var(--mono); color: var(--muted); font-style: normal; }
    details[open] { flex-basis: 100%; }
    summary { cursor: pointer; font-weight: 600; }
    details p { margin: 4px 0 0; }
    .verdict { font-weight: 620; }
    .verdict.good { color: var(--good); }
    .verdict.warn { color: var(--warn); }
    .row { display: flex; flex-wrap: wrap; gap: 8px; }
    /* A part of the map stays in sight, however much there is to read. */
    @media (max-width: 760px) { section { max-height: calc(.62 * (100dvh - 54px - var(--dock))); overflow-y: auto; } header { position: sticky; top: -10px; background: var(--raised); } .row { position: sticky; bottom: -10px; padding: 6px 0 10px; background: var(--raised); } }
  `];

  protected override readonly topics = ["run", "lesson", "settings", "tour"] as const;
  /** The lesson that was read: it is folded to its name and result, to make room for the map. */
  #folded = "";

  override render(): TemplateResult | typeof nothing {
    const now = current(this.store);
    if (!now || this.store.tour) return nothing;
    const { lesson, place } = now;
    const { grade, offer: { lessons } } = this.store;
    const next = lessons[place + 1];
    const isFolded = this.#folded === lesson.name;
    const fold = isFolded ? "Read the lesson" : "Show the name only";
    return html`<section aria-label="Lesson" data-testid="lesson">
      <header><h2><small>Lesson ${place + 1} of ${lessons.length}</small>${lesson.title}</h2>
        <button class="icon" data-testid="fold-lesson" aria-expanded=${!isFolded} aria-label=${fold} title=${fold}
          @click=${this.press(() => this.#fold(isFolded ? "" : lesson.name))}>${isFolded ? icons.plus : icons.minus}</button>
        <button class="icon" aria-label="Leave the lesson" title="Leave the lesson; the run goes on" @click=${this.press(() => leave(this.store))}>${icons.close}</button></header>
      ${isFolded ? nothing : html`<p>${lesson.fault}</p>
      <p><b>${lesson.task}</b></p>
      <ul>${grade?.marks.map((mark) => this.#mark(mark, grade.isOver))}</ul>`}
      ${isFolded && !grade?.isOver ? nothing : html`${this.#verdict(lesson)}
      <div class="row">
        ${grade?.isPassed && next ? html`<button class="next" data-testid="next-lesson" @click=${this.press(() => this.#go(next))}>Next: ${next.title}</button>` : nothing}
        <button data-testid="try-again" title="The same run from its beginning, with the settings as they are now" @click=${this.press(() => this.client.start())}>Try again</button>
        ${this.#isChanged(lesson) ? html`<button title="As it was given" @click=${this.press(() => teach(this.store, this.client, lesson))}>Undo all changes</button>` : nothing}
        ${isFolded ? nothing : html`<details><summary>Hint</summary><p class="muted">${lesson.hint}</p></details>`}
      </div>`}
    </section>`;
  }

  #fold(name: string): void {
    this.#folded = name;
    this.requestUpdate();
  }

  #mark({ measure, isLeast, bound, value, isMet }: Mark, isOver: boolean): TemplateResult {
    const { title, kind, meaning } = MEASURES[measure];
    const [now, asked] = [shown[kind](value), shown[kind](bound)];
    const state = isMet ? "met" : isOver ? "missed" : "";
    const told = isMet ? word("reached") : isOver ? word("missed") : "not yet";
    return html`<li class=${state} title=${meaning} data-testid="mark-${measure}" data-met=${isMet}>
      <span role="img" aria-label=${told}>${isMet ? "✓" : isOver ? "✗" : "·"}</span><span>${title}</span>
      <span><b>${Number.isFinite(value) ? now : DASH}</b> <i>${isLeast ? "≥" : "≤"} ${asked}</i></span></li>`;
  }

  #verdict({ seconds }: LessonInfo): TemplateResult {
    const { grade, playing } = this.store;
    if (grade?.isPassed) return html`<p class="verdict good" role="status" data-testid="verdict">Mended.</p>`;
    if (grade?.isOver) return html`<p class="verdict warn" role="status" data-testid="verdict">Not mended yet: change something, and try again.</p>`;
    return html`<p class="muted" data-testid="verdict">Graded when the robot is done, or at ${clock(seconds)} of its time${playing ? "" : "; the run is paused"}.</p>`;
  }

  #isChanged({ setup: given }: LessonInfo): boolean {
    const { method, settings } = this.store.setup;
    const keys = new Set([...Object.keys(given.settings), ...Object.keys(settings)]);
    return method !== given.method || [...keys].some((key) => settings[key] !== given.settings[key]);
  }

  #go(next: LessonInfo): void {
    location.hash = addressOf(next);
  }
}

customElements.define("slam-lesson", SlamLesson);
