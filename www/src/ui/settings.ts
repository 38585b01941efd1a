// Every setting of the run, from the core's table: grouped, searchable, with presets; changed at
// once or on restart.

import { css, nothing, type TemplateResult } from "lit";
import { current } from "../lessons.js";
import type { PresetInfo, SettingInfo, SettingValues } from "../protocol/module.js";
import { html, t } from "../words.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";
import { isChecked, valueOf } from "./input.js";
import { field, range, stored, written } from "./setting_words.js";

export class SlamSettings extends SlamElement {
  static override styles = css`
    h2 { margin-bottom: 10px; }
    input[type="search"] { min-height: 36px; width: 100%; padding: 0 10px; border: 1px solid var(--line); border-radius: 9px; background: var(--raised); }
    .bar { display: flex; gap: 8px; align-items: center; margin: 10px 0; padding: 8px 10px; border-radius: 10px; background: var(--sunk); border: 1px solid var(--line); font-size: 12.5px; }
    .bar span { flex: 1; }
    .all { display: flex; gap: 8px; align-items: center; margin-top: 10px; font-size: 13px; }
    .idle { margin: 10px 0; padding-left: 18px; font-size: 12.5px; color: var(--muted); }
    details { border-top: 1px solid var(--line); }
    summary > span:first-of-type { flex: 1; }
    .count { font-size: 12px; color: var(--accent-ink); }
    .presets { display: flex; flex-wrap: wrap; gap: 6px; margin-bottom: 8px; }
    .presets button { min-height: 30px; font-size: 12.5px; padding: 0 10px; }
    .presets button[aria-pressed="true"] { border-color: var(--accent); color: var(--accent-ink); }
    .row { display: grid; grid-template-columns: 1fr 116px 30px; gap: 2px 8px; align-items: center; padding: 7px 0; border-top: 1px solid color-mix(in srgb, var(--line) 55%, transparent); }
    .row label { font-size: 13px; }
    .row.changed label { color: var(--accent-ink); font-weight: 600; }
    .row small { grid-column: 1 / -1; font-size: 12px; line-height: 1.4; color: var(--muted); }
    .row em { font-style: normal; color: var(--warn-ink); }
    .field { display: flex; align-items: center; gap: 5px; }
    .field input[type="number"] { min-height: 32px; padding: 0 6px; text-align: right; font-family: var(--mono); font-size: 12.5px; }
    .field span { font: 500 11px/1 var(--mono); color: var(--muted); }
    .row.choice { grid-template-columns: 1fr 30px; }
    .row.choice .field { grid-column: 1 / -1; }
    .row.choice label { grid-column: 1; }
    .row.choice .back { grid-column: 2; grid-row: 1; }
    .back { min-height: 30px; width: 30px; padding: 0; border: 0; background: transparent; color: var(--muted); }
    .back svg { width: 15px; height: 15px; }
    .back[hidden] { display: block; visibility: hidden; }
    input[type="checkbox"] { width: 18px; height: 18px; accent-color: var(--accent); }
    p { font-size: 12.5px; color: var(--muted); margin: 10px 0; }
    @media (pointer: coarse) { .back { min-height: 36px; width: 36px; } .row { grid-template-columns: 1fr 116px 36px; } .field input[type="number"] { min-height: 40px; } .presets button { min-height: 40px; } input[type="checkbox"] { width: 24px; height: 24px; } }
  `;

  protected override readonly topics = ["settings", "run"] as const;
  #search = "";
  #all = false;

  override render(): TemplateResult {
    const { store } = this;
    const effective = store.settings.filter((s) => s.idle === "");
    const found = effective.filter((s) => matches(s, this.#search));
    // A search finds every setting, and changed ones stay visible.
    const shown = found.filter((s) => this.#all || this.#search !== "" || s.isBasic || this.#differs(s));
    const groups = [...new Set(shown.map((s) => s.group))];
    const changed = effective.filter((s) => this.#differs(s)).length;
    const isLesson = current(store) !== null;
    const idle = store.settings.filter((s) => s.idle !== "" && s.key in store.setup.settings);
    const waits = this.#waiting();
    return html`
      <h2>Settings</h2>
      <input type="search" data-testid="settings-search" placeholder="Search: gate, σ, range …" aria-label="Search the settings" .value=${this.#search} @input=${(e: Event) => { this.#search = valueOf(e); this.requestUpdate(); }}>
      <label class="all"><input type="checkbox" data-testid="settings-all" .checked=${this.#all} @change=${(e: Event) => { this.#all = isChecked(e); this.requestUpdate(); }}> All settings</label>
      ${waits.length > 0 ? html`<div class="bar" role="status" data-testid="settings-wait"><span>${waits.length === 1 ? t`${waits[0]} waits for a restart.` : t`${waits.map((name) => t(name)).join(", ")} wait for a restart.`}</span><button data-testid="settings-restart" @click=${() => this.client.again()}>${icons.again} Restart</button></div>` : ""}
      ${changed > 0 ? html`<div class="bar"><span>${differing(changed, isLesson)}</span><button data-testid="settings-reset" @click=${() => this.client.configure(this.#given)}>${isLesson ? "As it was given" : "All defaults"}</button></div>` : ""}
      ${idle.length > 0 ? html`<ul class="idle" data-testid="settings-idle">${idle.map((s) => html`<li>${s.idle}.</li>`)}</ul>` : ""}
      ${groups.map((group) => this.#group(group, shown.filter((s) => s.group === group)))}
      ${shown.length === 0 && this.#search !== "" ? html`<p>No setting matches. The search covers names, units and meanings.</p>` : ""}
    `;
  }

  /** The values that changes are compared with: the defaults, or those of the lesson, whose fault
      must not be revealed. */
  get #given(): SettingValues {
    return current(this.store)?.lesson.setup.settings ?? {};
  }

  #differs({ key, default: byDefault }: SettingInfo): boolean {
    return (this.store.setup.settings[key] ?? byDefault) !== (this.#given[key] ?? byDefault);
  }

  #group(group: string, settings: readonly SettingInfo[]): TemplateResult {
    const presets = this.store.offer.presets.filter((p) => p.group === group);
    const changed = settings.filter((s) => this.#differs(s)).length;
    return html`<details data-testid="settings-${group}" ?open=${this.#search !== ""}>
      <summary><span>${group}</span>${changed > 0 ? html`<span class="count">${changed} changed</span>` : ""}</summary>
      ${presets.length > 0 ? html`<div class="presets" role="group" aria-label="Presets of ${group}">${presets.map((preset) => html`<button title=${preset.meaning} aria-pressed=${this.#holds(preset)} @click=${() => this.#apply(preset)}>${preset.name}</button>`)}</div>` : ""}
      ${settings.map((s) => this.#row(s))}
    </details>`;
  }

  #row(s: SettingInfo): TemplateResult {
    const { settings } = this.store.setup;
    const value = settings[s.key] ?? s.default;
    const differs = this.#differs(s);
    const before = this.#given[s.key] ?? s.default;
    const id = `s-${s.key}`;
    return html`<div class="row ${differs ? "changed" : ""} ${s.kind === "choice" ? "choice" : ""}">
      <label for=${id}>${s.name}</label>
      <span class="field">${this.#field(s, id, value)}</span>
      <button class="back" ?hidden=${!differs} title="Back to ${written(s, before)}" aria-label="${s.name}: back to ${written(s, before)}" @click=${() => this.#set(s, before)}>${icons.again}</button>
      <small>${s.meaning} ${s.kind === "real" || s.kind === "whole" ? html`${range(s)}, default ${written(s, s.default)}.` : ""}${s.atOnce ? "" : html` <em>On restart.</em>`}</small>
    </div>`;
  }

  #field(s: SettingInfo, id: string, value: number): TemplateResult {
    if (s.kind === "switch") return html`<input id=${id} type="checkbox" data-testid=${id} .checked=${value !== 0} @change=${(e: Event) => this.#set(s, isChecked(e) ? 1 : 0)}>`;
    if (s.kind === "choice") {
      return html`<select id=${id} data-testid=${id} @change=${(e: Event) => this.#set(s, Number(valueOf(e)))}>
        ${s.choices.map((choice, i) => html`<option value=${i} .selected=${i === value}>${choice}</option>`)}</select>`;
    }
    return html`<input id=${id} type="number" inputmode="decimal" step="any" data-testid=${id} .value=${field(s, value)}
      @change=${(e: Event) => this.#type(s, e.target as HTMLInputElement, value)}>${s.unit ? html`<span>${s.unit}</span>` : nothing}`;
  }

  /** A number out of range is not used; the field shows the present one again. */
  #type(s: SettingInfo, input: HTMLInputElement, before: number): void {
    const value = stored(s, Number(input.value || NaN));
    const fits = value >= s.low && value <= s.high && (s.kind !== "whole" || Number.isInteger(value));
    if (fits) return this.#set(s, value);
    input.value = field(s, before);
    const kind = s.kind === "whole" ? "a whole number" : "a number";
    this.store.set("toast", { toast: { level: "warn", text: t`${s.name} is ${kind} from ${range(s)}; it stays ${written(s, before)}.` } });
  }

  #set(s: SettingInfo, value: number): void {
    const { [s.key]: _, ...others } = this.store.setup.settings;
    this.client.configure(this.#possible(value === s.default ? others : { ...others, [s.key]: value }));
  }

  /** Without settings whose condition, the value of another setting, no longer holds. */
  #possible(settings: SettingValues): SettingValues {
    const rows = new Map(this.store.settings.map((s) => [s.key, s]));
    const holds = (key: string): boolean => {
      const row = rows.get(key);
      const other = rows.get(row?.needs ?? "");
      if (!row || !other) return true;
      const value = settings[other.key] ?? other.default;
      return holds(other.key) && (row.needed.length > 0 ? row.needed.includes(value) : value > 0);
    };
    return Object.fromEntries(Object.entries(settings).filter(([key]) => holds(key)));
  }

  #apply(preset: PresetInfo): void {
    const keys = new Set(this.store.settings.filter((s) => s.group === preset.group).map((s) => s.key));
    const others = Object.entries(this.store.setup.settings).filter(([key]) => !keys.has(key));
    this.client.configure(this.#possible({ ...Object.fromEntries(others), ...preset.values }));
  }

  /** Whether the settings of the group are those of the preset. */
  #holds(preset: PresetInfo): boolean {
    const of = this.store.settings.filter((s) => s.group === preset.group);
    return of.every((s) => s.idle !== "" || (this.store.setup.settings[s.key] ?? s.default) === (preset.values[s.key] ?? s.default));
  }

  /** Names of changed settings that act only at the next start of the run. */
  #waiting(): string[] {
    const { setup, started, settings } = this.store;
    return settings.filter((s) => s.idle === "" && !s.atOnce && setup.settings[s.key] !== started.settings[s.key]).map((s) => s.name);
  }
}

function differing(count: number, isLesson: boolean): string {
  if (isLesson) return count === 1 ? t`${count} setting differs from what the lesson gave.` : t`${count} settings differ from what the lesson gave.`;
  return count === 1 ? t`${count} setting differs from its default.` : t`${count} settings differ from their defaults.`;
}

/** Searches the words of the table, in English and as shown. */
function matches(s: SettingInfo, search: string): boolean {
  const words = [s.group, s.name, s.meaning];
  const all = [...words, ...words.map((each) => t(each)), s.unit, s.key].join(" ").toLowerCase();
  return search.toLowerCase().split(/\s+/).every((word) => all.includes(word));
}

customElements.define("slam-settings", SlamSettings);
