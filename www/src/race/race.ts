// Two to four runs side by side: lets the visitor choose what to compare the shown run with, keeps
// all runs at the same moment, and shows their maps, names and errors.
//
// | what | handled by |
// |---|---|
// | time: play, pause, step, speed, to another moment | the run that is shown; the others follow it (`Rival`), and it waits for the slowest |
// | commands to the robot, changes in its world | applied to each run at the same run time |
// | view, layers, theme | those of the page |

import { css, nothing, type TemplateResult } from "lit";
import { current as currentLesson } from "../lessons.js";
import type { Command } from "../protocol.js";
import { needsPriorMap } from "../protocol/methods.js";
import type { MethodName, SettingInfo, SettingValues } from "../protocol/module.js";
import { isNarrow } from "../screen.js";
import { dialog, SlamDialog } from "../ui/dialog.js";
import { clock } from "../ui/format.js";
import { icons } from "../ui/icons.js";
import { isChecked, valueOf } from "../ui/input.js";
import { range, stored, written } from "../ui/setting_words.js";
import type { SlamMap } from "../view/map_view.js";
import { html, t } from "../words.js";
import "./chip.js";
import type { SlamRaceChip } from "./chip.js";
import { layOut } from "./panes.js";
import "./plot.js";
import type { SlamRacePlot } from "./plot.js";
import { type Difference, Rival, type RunParts } from "./rival.js";
import { COLOURS, MOST_RUNS } from "./swatch.js";

/** Commands to the robot and changes in its world, applied to all runs. */
const SHARED: ReadonlySet<Command["kind"]> = new Set(["explore", "manual", "goto", "drive", "stop", "kidnap", "door", "cycle"]);
/** How far the run that is shown may be ahead of the slowest, s; at higher speeds AHEAD_WALL
    counts, in wall seconds. */
const AHEAD = 0.2;
const AHEAD_WALL = 0.25;
/** The same at unlimited speed, s. */
const MOST_AHEAD = 3;

export class SlamRace extends SlamDialog {
  static override styles = [dialog, css`
    dialog { width: min(720px, calc(100vw - 24px)); }
    h4 { margin: 16px 0 8px; font: 600 15px/1.3 var(--sans); }
    .methods { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(290px, 100%), 1fr)); gap: 8px; }
    label.method { display: grid; align-content: start; grid-template-columns: 22px 1fr; gap: 2px 8px; padding: 9px 12px; border: 1px solid var(--line); border-radius: 12px; background: var(--raised); cursor: pointer; }
    label.method:has(:checked) { border-color: var(--accent); box-shadow: inset 0 0 0 1px var(--accent); }
    label.method b { font-weight: 600; }
    label.method small { grid-column: 2; color: var(--muted); font-size: 12.5px; line-height: 1.35; }
    input[type="checkbox"], input[type="radio"] { width: 18px; height: 18px; margin: 1px 0 0; accent-color: var(--accent); }
    .setting { display: grid; grid-template-columns: minmax(0, 1fr) 150px; gap: 8px; align-items: center; }
    .field { display: flex; gap: 6px; align-items: center; }
    .field span { font: 500 12px/1 var(--mono); color: var(--muted); white-space: nowrap; }
    .about { margin: 8px 0 0; font-size: 12.5px; color: var(--muted); }
    .bad { color: var(--warn-ink); }
    .from { display: flex; flex-wrap: wrap; gap: 6px 18px; margin-top: 8px; }
    .from label { display: flex; gap: 7px; align-items: center; font-size: 13.5px; min-height: 30px; }
    footer { display: flex; flex-wrap: wrap; gap: 10px; align-items: center; margin-top: 20px; }
    footer .go { min-height: 44px; padding: 0 18px; border-color: transparent; background: var(--accent); color: var(--on-accent); }
    footer p { flex: 1; margin: 0; font-size: 12.5px; color: var(--muted); }
    @media (max-width: 560px) { .setting { grid-template-columns: 1fr; } }
    @media (pointer: coarse) { .from label { min-height: 44px; } }
  `];

  protected override readonly topics = ["run", "settings"] as const;
  /** The map of the run that is shown; main.ts sets it, and `beside`. */
  map!: SlamMap;
  /** Creates the parts of another run. */
  beside!: () => RunParts;

  #rivals: readonly Rival[] = [];
  #plot: SlamRacePlot | null = null;
  #ofShown: SlamRaceChip | null = null;
  #heldAt = Infinity;
  // What is chosen in the dialog.
  #methods: ReadonlySet<MethodName> = new Set();
  #key = "";
  #value = NaN;
  /** The value as it was typed. */
  #text = "";
  #isFork = false;
  #goesOn = false;

  override connectedCallback(): void {
    super.connectedCallback();
    const { store, client } = this;
    const begun = client.onStart;
    client.onStart = (isAgain) => {
      begun(isAgain);
      if (!isAgain) this.#restart();
    };
    client.diverts = (command) => {
      this.#pass(command);
      return false;
    };
    store.on("view", () => this.#look());
    // An experiment is set up to show one thing only.
    store.on("exhibit", () => {
      if (store.exhibit) for (const rival of this.#rivals) this.#close(rival);
    });
    store.on("theme", () => this.#rivals.forEach(({ parts }) => parts.store.notify("theme")));
    store.on("run", () => this.#rivals.forEach(({ parts }) => (parts.store.aiming = store.aiming)));
  }

  /** Runs beside the one that is shown, for tests and the console. */
  get figures(): readonly object[] {
    return this.#rivals.map(({ difference: { name }, parts: { store, map }, isThere }) => ({
      name, isThere, playing: store.playing, status: store.status, hash: store.hash, method: store.method,
      camera: { x: map.camera.x, y: map.camera.y, scale: map.camera.scale, angle: map.camera.angle }, layers: { ...store.layers },
    }));
  }

  /** The run waits while the visitor chooses what to compare it with. */
  override show(): void {
    const { store, client } = this;
    const reason = this.#refusal();
    if (reason !== "") return store.set("toast", { toast: { level: "warn", text: reason } });
    if (this.shown) return;
    [this.#methods, this.#key, this.#value, this.#isFork] = [new Set(), "", NaN, false];
    this.#goesOn = store.playing;
    if (this.#goesOn) client.send({ kind: "pause" });
    this.requestUpdate();
    super.show();
  }

  #refusal(): string {
    const { store } = this;
    if (store.source === "bridge") return "A real robot drives once: record it, and compare methods on the recording.";
    if (currentLesson(store)) return "A lesson is tried alone: what it asks is yours to find.";
    if (!store.status || store.reading) return "Wait until the run has begun.";
    return this.#rivals.length + 1 >= MOST_RUNS ? t`No more than ${MOST_RUNS} runs stand side by side: end one first.` : "";
  }

  override render(): TemplateResult {
    const { store } = this;
    const count = this.#chosen().length;
    const room = MOST_RUNS - 1 - this.#rivals.length;
    const where = store.source === "replay" ? "on the same recording" : "in the same building, with the same seed";
    return html`<dialog aria-labelledby="title" data-testid="race" @close=${() => this.#left()} @click=${(e: Event) => e.target === e.currentTarget && this.close()}>
      <header><h3 id="title">Compare with…</h3><button class="icon" aria-label="Close" @click=${() => this.close()}>${icons.close}</button></header>
      <p>Other runs beside this one, ${where}, at the same moment: maps side by side, errors in one plot.</p>
      ${store.source === "sim" ? html`<p>Each drives by itself, by the map that it draws: their ways may part.</p>` : nothing}
      <h4 id="methods">By another method</h4>
      <div class="methods" role="group" aria-labelledby="methods">${store.offer.methods.filter(({ name }) => this.#isOffered(name)).map(({ name, title, meaning }) => html`
        <label class="method"><input type="checkbox" data-testid="race-${name}" .checked=${this.#methods.has(name)} ?disabled=${!this.#methods.has(name) && count >= room} @change=${(e: Event) => this.#toggle(name, isChecked(e))}><b>${title}</b><small>${meaning}</small></label>`)}</div>
      <h4 id="setting">By the same method, with one setting changed</h4>
      ${this.#settingFields(count >= room)}
      <footer><button class="go" data-testid="race-go" ?disabled=${count === 0} @click=${() => this.#go()}>${icons.beside} Run side by side</button>
        <p role="status">${count === 0 ? room === 1 ? "There is room for one more." : t`Choose up to ${room}.` : t`${count + this.#rivals.length + 1} runs in all.`}</p></footer>
    </dialog>`;
  }

  #isOffered(name: MethodName): boolean {
    const { store } = this;
    const isShown = name === store.method || this.#rivals.some(({ difference }) => difference.isByMethod && difference.method === name);
    return !isShown && (!needsPriorMap(name) || store.source === "sim" || store.setup.priorMap !== null);
  }

  #settingFields(isFull: boolean): TemplateResult {
    const { store } = this;
    const settings = store.settings.filter((s) => s.idle === "");
    const groups = [...new Set(settings.map((s) => s.group))];
    const s = this.#setting;
    const now = clock(store.status?.time ?? 0);
    const isBad = s !== null && Number.isNaN(this.#value);
    return html`<div class="setting" role="group" aria-labelledby="setting">
      <select data-testid="race-setting" aria-label="Setting" ?disabled=${isFull && !s} @change=${(e: Event) => this.#take(valueOf(e))}>
        <option value="" .selected=${this.#key === ""}>None</option>
        ${groups.map((group) => html`<optgroup label=${group}>${settings.filter((each) => each.group === group).map((each) => html`<option value=${each.key} .selected=${each.key === this.#key}>${each.name}</option>`)}</optgroup>`)}
      </select>
      ${s ? html`<span class="field">${this.#field(s)}</span>` : nothing}</div>
      ${s ? html`<p class="about ${isBad ? "bad" : ""}">${isBad ? html`Another number than ${written(s, this.#before(s))}, from ${range(s)}.` : html`${s.meaning} In this run: ${written(s, this.#before(s))}.`}</p>` : nothing}
      ${s && store.source === "sim" ? html`<div class="from" role="radiogroup" aria-label="From when on">
        <label><input type="radio" name="from" data-testid="race-from-start" .checked=${!this.#isFork} @change=${() => this.#fork(false)}> from the beginning</label>
        <label title=${s.atOnce ? "" : "This one acts only at the start of a run"}><input type="radio" name="from" data-testid="race-fork" .checked=${this.#isFork} ?disabled=${!s.atOnce} @change=${() => this.#fork(true)}> from here on, ${now}</label></div>` : nothing}`;
  }

  #field(s: SettingInfo): TemplateResult {
    const choices = s.kind === "switch" ? ["off", "on"] : s.kind === "choice" ? s.choices : null;
    if (choices) {
      return html`<select data-testid="race-value" aria-label=${s.name} @change=${(e: Event) => this.#give(Number(valueOf(e)))}>${choices.map((choice, i) => html`<option value=${i} .selected=${i === this.#value}>${choice}</option>`)}</select>`;
    }
    return html`<input type="number" inputmode="decimal" step="any" data-testid="race-value" aria-label=${s.name} .value=${this.#text}
      @input=${(e: Event) => this.#type(s, valueOf(e))}>${s.unit ? html`<span>${s.unit}</span>` : nothing}`;
  }

  get #setting(): SettingInfo | null {
    return this.store.settings.find(({ key }) => key === this.#key) ?? null;
  }

  #before(s: SettingInfo): number {
    return this.store.setup.settings[s.key] ?? s.default;
  }

  #toggle(name: MethodName, on: boolean): void {
    const methods = new Set(this.#methods);
    if (on) methods.add(name);
    else methods.delete(name);
    this.#methods = methods;
    this.requestUpdate();
  }

  /** Chooses a setting; the value of a switch or a choice changes at once. */
  #take(key: string): void {
    this.#key = key;
    this.#text = "";
    const s = this.#setting;
    const others = s?.kind === "switch" ? [0, 1] : (s?.choices ?? []).map((_, i) => i);
    this.#value = s ? others.find((value) => value !== this.#before(s)) ?? NaN : NaN;
    this.#isFork &&= s?.atOnce ?? false;
    this.requestUpdate();
  }

  #type(s: SettingInfo, text: string): void {
    this.#text = text;
    const value = stored(s, Number(text || NaN));
    const fits = value >= s.low && value <= s.high && (s.kind !== "whole" || Number.isInteger(value)) && value !== this.#before(s);
    this.#give(fits ? value : NaN);
  }

  #give(value: number): void {
    const s = this.#setting;
    this.#value = s && value === this.#before(s) ? NaN : value;
    this.requestUpdate();
  }

  #fork(isFork: boolean): void {
    this.#isFork = isFork;
    this.requestUpdate();
  }

  /** What was chosen. */
  #chosen(): readonly Difference[] {
    const { store } = this;
    const { settings } = store.setup;
    const methods = store.offer.methods.filter(({ name }) => this.#methods.has(name));
    const others = methods.map(({ name, title }): Difference => ({ name: title, method: name, isByMethod: true, settings, from: null }));
    const s = this.#setting;
    if (!s || Number.isNaN(this.#value)) return others;
    const from = this.#isFork ? store.status?.time ?? null : null;
    const changed: SettingValues = { ...settings, [s.key]: this.#value };
    const name = `${s.name} ${written(s, this.#value)}${from === null ? "" : t` from ${clock(from)}`}`;
    return [...others, { name, method: store.method, isByMethod: false, settings: changed, from }];
  }

  #go(): void {
    for (const difference of this.#chosen()) this.#add(difference);
    this.close();
    // On a phone the curves would cover the maps.
    if (isNarrow()) return;
    this.store.set("tab", { tab: "plots" });
    requestAnimationFrame(() => document.querySelector("#plots-panel")?.scrollIntoView({ block: "start" }));
  }

  #left(): void {
    if (this.#goesOn && !this.store.playing) this.client.send({ kind: "play" });
    this.#goesOn = false;
  }

  #add(difference: Difference): void {
    const colour = COLOURS.find((colour, i) => i > 0 && this.#rivals.every((rival) => rival.colour !== colour));
    if (colour === undefined) return;
    const parts = this.beside();
    const rival = new Rival(parts, difference, colour);
    const place = COLOURS.indexOf(colour);
    parts.map.lead = this.map;
    parts.client.diverts = (command) => this.#redirect(command);
    parts.client.onLost = () => this.#close(rival);
    parts.store.on("toast", () => this.#tell(rival));
    const pane = document.createElement("section");
    pane.setAttribute("aria-label", t(difference.name));
    pane.dataset["testid"] = `race-pane-${place}`;
    pane.append(parts.map, Object.assign(this.#chip(parts, difference.name, place, () => this.#close(rival)), { isThere: () => rival.isThere }));
    document.querySelector("#maps")?.append(pane);
    this.#rivals = [...this.#rivals, rival];
    this.#arrange();
    this.#look();
    void rival.begin(this.#shown);
    if (this.#rivals.length === 1) requestAnimationFrame(() => this.#tick());
  }

  #chip({ store, scene, client }: Omit<RunParts, "map">, name: string, place: number, onClose: (() => void) | null): SlamRaceChip {
    return Object.assign(document.createElement("slam-race-chip") as SlamRaceChip, { store, scene, client, name, place, colour: COLOURS[place], onClose });
  }

  #close(rival: Rival): void {
    this.#rivals = this.#rivals.filter((each) => each !== rival);
    rival.parts.map.parentElement?.remove();
    rival.end();
    this.#arrange();
  }

  get #shown(): RunParts {
    const { store, scene, client, map } = this;
    return { store, scene, client, map };
  }

  /** Lays out as many maps as there are runs, and shows their curves. */
  #arrange(): void {
    const { store, scene, client } = this;
    layOut(this.#rivals.length + 1);
    this.map.others = this.#rivals.map(({ parts }) => parts.scene);
    const name = store.offer.methods.find(({ name }) => name === store.method)?.title ?? store.method;
    this.#ofShown?.remove();
    this.#ofShown = null;
    if (this.#rivals.length === 0) {
      this.#plot?.remove();
      this.#plot = null;
      this.#hold(Infinity);
      return;
    }
    this.#ofShown = this.#chip(this.#shown, name, 0, null);
    this.#ofShown.toggleAttribute("shown", true);
    this.map.parentElement?.append(this.#ofShown);
    if (!this.#plot) {
      this.#plot = Object.assign(document.createElement("slam-race-plot") as SlamRacePlot, { store, scene, client });
      document.querySelector("#plots-panel")?.prepend(this.#plot);
    }
    const rivals = this.#rivals.map(({ parts, difference, colour }) => ({ store: parts.store, scene: parts.scene, name: difference.name, colour, place: COLOURS.indexOf(colour) }));
    this.#plot.show([{ store, scene, name, colour: COLOURS[0], place: 0 }, ...rivals]);
  }

  /** Shows the same layers in each map, and requests their data. */
  #look(): void {
    const { layers, layerOrder, gridView } = this.store;
    const field = gridView === "continuous" || gridView === "three" || !layers.grid ? null : gridView;
    for (const { parts: { store, client } } of this.#rivals) {
      store.set("view", { layers, layerOrder, gridView });
      for (const kind of ["rooms", "points", "wheels"] as const) client.relay({ kind, on: layers[kind] });
      client.relay({ kind: "field", name: field });
    }
  }

  /** Passes a command given to the shown run to the others, for when they are as far. */
  #pass(command: Command): void {
    const time = this.store.status?.time ?? 0;
    if (SHARED.has(command.kind)) for (const rival of this.#rivals) rival.doAt(time, command);
  }

  /** A command given on the map of another run goes to all. */
  #redirect(command: Command): boolean {
    if (!SHARED.has(command.kind)) return false;
    this.client.send(command);
    this.store.set("run", { aiming: false, isStopped: false });
    return true;
  }

  /** Shows the messages of another run, except the comparison with its link, which was made for
      it. */
  #tell({ parts, difference }: Rival): void {
    const { toast } = parts.store;
    if (toast && toast.topic !== "link") this.store.set("toast", { toast: { level: toast.level, text: `${difference.name}: ${toast.text}` } });
  }

  /** The run that is shown restarts: so do the others, if they can. */
  #restart(): void {
    const { store, client } = this;
    for (const rival of this.#rivals) {
      const recording = store.source === "replay" ? client.files.recording?.file ?? null : null;
      // A run with the method that is now shown would be a duplicate.
      const isTwin = rival.difference.isByMethod && rival.difference.method === store.method;
      if (store.source === "bridge" || rival.recording !== recording || isTwin || currentLesson(store)) this.#close(rival);
      else void rival.begin(this.#shown);
    }
    if (this.#rivals.length > 0) this.#arrange();
  }

  #tick(): void {
    if (this.#rivals.length === 0) return;
    requestAnimationFrame(() => this.#tick());
    const { store } = this;
    for (const rival of this.#rivals) rival.follow(store);
    const going = this.#rivals.filter(({ isOver }) => !isOver);
    const ahead = store.speed === Infinity ? MOST_AHEAD : Math.max(AHEAD, AHEAD_WALL * store.speed);
    this.#hold(Math.min(...going.map(({ time }) => time)) + ahead);
    this.#plot?.feed();
  }

  #hold(time: number): void {
    if (time === this.#heldAt) return;
    this.#heldAt = time;
    this.client.relay({ kind: "hold-at", time });
  }
}

customElements.define("slam-race", SlamRace);
