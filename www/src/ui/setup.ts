// The start of a run: world, sensor, seed, method; opening and saving files.

import { css, type TemplateResult } from "lit";
import { opened } from "../chosen.js";
import { openExample } from "../example.js";
import { needsPriorMap } from "../protocol/methods.js";
import { ofAnySensor } from "../protocol/setup.js";
import type { MethodName } from "../protocol/module.js";
import { isNarrow, isTouched } from "../screen.js";
import { anySeed } from "../seed.js";
import { noteChoice } from "../visit.js";
import { html, t } from "../words.js";
import { worldTitle } from "../worlds.js";
import { SlamElement } from "./element.js";
import { icons } from "./icons.js";
import { filesOf, valueOf } from "./input.js";

/** The module takes 32 bits. */
const MOST_SEED = 4_294_967_295;

/** What a sensor can do, and what it cannot. */
const SENSOR_WORDS: Readonly<Record<string, string>> = {
  lidar: "RPLIDAR: 360 beams all round to 12 m, one turn in 0.18 s. Sees walls as lines; glass and dark walls hardly.",
  sick: "SICK: half of the horizon to 20 m, very precise. Nothing behind the robot; says its greatest range where nothing comes back.",
  rangers: "Sharp rangers on a servo: 0.2 to 1.5 m, and only while the robot stands. Drives by the cycle.",
  sonar: "16 cones of 30°: each hears the nearest thing, no matter where in it. No lines to recognise, so the pose comes from the wheels alone, and drifts.",
};

export class SlamSetup extends SlamElement {
  static override styles = css`
    h2 { margin-bottom: 12px; }
    .grid { display: grid; grid-template-columns: minmax(0, 5fr) minmax(0, 7fr); gap: 10px; }
    .recorded { grid-template-columns: minmax(0, 1fr) auto; }
    label { display: grid; gap: 4px; font-size: 12.5px; color: var(--muted); }
    label > * { color: var(--ink); font-size: 14px; }
    .wide { grid-column: 1 / -1; }
    .grid label:has(> select) { min-width: 0; }
    .seed { display: flex; gap: 6px; }
    .seed button:not(.icon), .seed select { flex: 1; min-width: 0; }
    /* Beside two others there is room for the word alone. */
    .seed .icon:not([hidden]) ~ button:not(.icon) { padding: 0 4px; }
    .seed .icon:not([hidden]) ~ button:not(.icon) svg { display: none; }
    @media (max-width: 400px) { .seed { gap: 4px; } }
    .files { display: grid; grid-template-columns: 1fr 1fr; gap: 8px; margin-top: 12px; }
    .files button { padding: 0 6px; }
    p.about { margin: 0; color: var(--muted); line-height: 1.4; }
    p { margin: 10px 0 0; font-size: 12.5px; }
    .files label { display: contents; }
  `;

  protected override readonly topics = ["run"] as const;

  override render(): TemplateResult {
    const { setup, source, title, offer: { worlds, sensors, methods } } = this.store;
    const own = setup.worldJson !== null;
    const recorded = source !== "sim";
    const { method } = this.store;
    return html`
      <h2 id="run">Run</h2>
      <div class="grid ${recorded ? "recorded" : ""}" role="group" aria-labelledby="run">
        <label class="wide">World
          <span class="seed">
          <select data-testid="world" @change=${(e: Event) => this.#restart({ world: valueOf(e), worldJson: null })}>
            ${recorded ? html`<option selected value="">${source === "bridge" ? "Robot at" : "Recording:"} ${title}</option>` : ""}
            ${own ? html`<option .selected=${source === "sim"} value=${setup.world} disabled>${setup.world}</option>` : ""}
            ${worlds.map((w) => html`<option value=${w} .selected=${source === "sim" && !own && w === setup.world}>${worldTitle(w)}</option>`)}
          </select>
          <button class="icon" title="Draw a world of your own, or change this one (O)" aria-label="Draw a world" data-testid="draw-world"
            @click=${() => dispatchEvent(new Event("show-editor"))}>${icons.pencil}</button>
          </span>
        </label>
        <label ?hidden=${recorded}>Sensor
          <select data-testid="sensor" title=${sensors.find(({ name }) => name === setup.sensor)?.title ?? ""} @change=${(e: Event) => this.#restart({ sensor: valueOf(e) })}>
            ${sensors.map((s) => html`<option value=${s.name} .selected=${setup.sensor === s.name}>${s.title}</option>`)}
          </select>
        </label>
        <label>Method
          <select data-testid="method" title=${methods.find(({ name }) => name === method)?.title ?? ""} @change=${(e: Event) => this.#choose(valueOf(e) as MethodName)}>
            ${methods.filter(({ name }) => !needsPriorMap(name) || source === "sim" || setup.priorMap).map(({ name, title, meaning }) => html`<option value=${name} title=${meaning} .selected=${method === name}>${title}</option>`)}
          </select>
        </label>
        ${recorded ? "" : html`<p class="wide about" data-testid="about-sensor">${SENSOR_WORDS[setup.sensor] ?? ""}${setup.calibration && setup.sensor === "rangers" ? html` <b>Own calibration.</b>` : ""}</p>`}
        <label ?hidden=${recorded}>Seed
          <span class="seed">
            <input type="number" inputmode="numeric" min="0" max="4294967295" step="1" data-testid="seed" .value=${String(setup.seed)}
              @change=${this.#seed}>
          </span>
        </label>
        <label><span class="muted">&nbsp;</span>
          <span class="seed">
            <button ?hidden=${recorded} class="icon" title="Another seed" aria-label="Another seed" data-testid="dice"
              @click=${() => this.#restart({ seed: anySeed() })}>${icons.dice}</button>
            <button ?hidden=${recorded} class="icon" title="Copy the link of this run: what it starts from, and all that you did (K)" aria-label="Copy the link of this run" data-testid="copy-link"
              @click=${() => this.client.copyLink()}>${icons.link}</button>
            <button data-testid="restart" title="Start again (R)" @click=${() => this.client.again()}>${icons.again} Restart</button>
          </span>
        </label>
      </div>
      <div class="files">
        <label>
          <input type="file" multiple data-testid="file" aria-label="Open ${opened()}" @change=${(e: Event) => void this.client.files.openAll(filesOf(e))}>
          <span class="button">${icons.open} Open file…</span>
        </label>
        <button data-testid="save" title="Save the map, the walls, the way, the scans, pictures, curves: one file, or several in one archive (Y, or M)" aria-keyshortcuts="Y M Shift+A" @click=${() => dispatchEvent(new Event("show-saving"))}>${icons.save} Save…</button>
      </div>
      ${source === "replay" ? html`<p class="muted">Showing the recording <b>${title}</b>. Choose a world to go back to the simulation.</p>`
        : html`<details class="muted"><summary>What can be opened</summary>${isTouched() ? t`Open: ${opened()}.` : t`Open or drop anywhere: ${opened()}.`}
          <p>Nothing at hand? <button data-testid="example" title="Scans and odometry of a drive all round a ring, from our own simulation" @click=${this.press(() => void openExample(this.store, this.client))}>Map an example</button></p></details>`}
    `;
  }

  override connectedCallback(): void {
    super.connectedCallback();
    addEventListener("show-openable", () => void this.#showOpenable());
  }

  /** Opens the list of what can be opened. */
  async #showOpenable(): Promise<void> {
    if (isNarrow()) this.store.set("tab", { tab: "run" });
    await this.updateComplete;
    const list = this.renderRoot.querySelector("details");
    if (!list) return;
    list.open = true;
    list.scrollIntoView({ block: "nearest" });
  }

  #choose(method: MethodName): void {
    noteChoice(this.store, { method });
    this.client.again(method);
  }

  #restart(patch: Partial<typeof this.store.setup>): void {
    const { sensor, settings, calibration } = this.store.setup;
    const leaves = patch.sensor !== undefined && patch.sensor !== sensor;
    this.client.start({ mode: "explore", settings: leaves ? ofAnySensor(settings, this.store.settings) : settings, calibration: leaves ? null : calibration, ...patch });
  }

  #seed(event: Event): void {
    const input = event.target as HTMLInputElement;
    const seed = Number(input.value || NaN);
    if (Number.isInteger(seed) && seed >= 0 && seed <= MOST_SEED) {
      this.#restart({ seed });
      return;
    }
    // The field shows the seed of the run again.
    input.value = String(this.store.setup.seed);
    this.store.set("toast", { toast: { level: "warn", text: t`A seed is a whole number from 0 to ${MOST_SEED}; the run goes on with ${this.store.setup.seed}.` } });
  }
}

customElements.define("slam-setup", SlamSetup);
