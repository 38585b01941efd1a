// The prior map: where it comes from, where the robot begins in it, and whether it fits.

import { css, nothing, type TemplateResult } from "lit";
import type { LocalisationName, PriorMapSetup } from "../protocol/module.js";
import { needsPriorMap } from "../protocol/methods.js";
import { html, t } from "../words.js";
import { SlamElement } from "./element.js";
import { percent } from "./format.js";
import { icons } from "./icons.js";
import { filesOf } from "./input.js";
import { section } from "./style.js";

/** The fields of the start: key, label, and page units per unit of the module. */
const START = [["x", "x, m", 1], ["y", "y, m", 1], ["heading", "heading, °", 180 / Math.PI]] as const;

const LOCALISATION_WORDS: Record<LocalisationName, string> = {
  localised: "The robot knows where it is.",
  ambiguous: "What it sees fits in several places, or not yet for long enough: let it drive on.",
  lost: "What it sees fits nowhere where it believes to be: it is lost, and searches the map.",
};

export class SlamPriorMap extends SlamElement {
  static override styles = [section, css`
    [data-testid="kidnap"] { margin-bottom: 8px; }
    .two label { display: contents; }
    .two, .three { display: grid; grid-template-columns: 1fr 1fr; gap: 8px; margin-bottom: 8px; }
    .three { grid-template-columns: 1fr 1fr 1fr; }
    .three label { display: grid; gap: 4px; font-size: 12.5px; color: var(--muted); }
    .check { display: flex; gap: 8px; align-items: baseline; margin-bottom: 8px; font-size: 13px; }
    input[type="number"] { width: 100%; min-width: 0; }
  `];

  protected override readonly topics = ["run", "frame"] as const;

  override render(): TemplateResult {
    const { source, method, setup } = this.store;
    const { priorMap } = setup;
    const isUsed = needsPriorMap(method);
    return html`
      <h2 id="prior-map">Prior map</h2>
      ${isUsed ? this.#used(priorMap) : html`<p>Give the robot a map, and it only has to find itself in it: a map of ROS, OGmap.txt, a submap (.smap), a floor plan (.svg), a world (.json), or what it has mapped so far. It may be of this world or of another.</p>`}
      <div class="two">
        <label>
          <input type="file" accept=".yaml,.yml,.pgm,.png,.txt,.smap,.svg,.json" multiple data-testid="prior-map-file" aria-label="Open a map to be found in: YAML with its image, OGmap.txt, a submap, SVG or a world" @change=${(e: Event) => void this.client.files.openKnown(filesOf(e))}>
          <span class="button">${icons.open} Open map…</span>
        </label>
        <button data-testid="prior-map-this" title="Begin again, and find yourself in the map drawn so far" @click=${() => this.client.localiseInThisMap()}>${icons.again} Map so far</button>
      </div>
      ${isUsed && priorMap && source === "sim" ? html`<button data-testid="prior-map-world" @click=${() => this.client.localiseIn(null)}>Use the walls of the world instead</button>` : nothing}
    `;
  }

  #used(priorMap: PriorMapSetup | null): TemplateResult {
    return html`
      <p data-testid="prior-map-name">The robot finds itself ${priorMap ? html`in <b>${priorMap.name}</b>, drawn on the map as the layer Prior map.` : "among the true walls of its world."}</p>
      ${this.#fit()}
      ${this.#localisation()}
      ${priorMap && this.store.source === "bridge" ? html`<p>Where the robot stood when it was given the map, in the frame of its file. Whoever changes that says where it stands now: leave it standing meanwhile.</p>` : nothing}
      ${priorMap ? html`<label class="check"><input type="checkbox" data-testid="prior-map-anywhere" .checked=${priorMap.anywhere} @change=${(e: Event) => this.client.localiseIn({ ...priorMap, anywhere: (e.target as HTMLInputElement).checked }, "particle-localisation")}> It may begin anywhere in it, and finds out where.</label>` : nothing}
      ${priorMap && !priorMap.anywhere ? html`<div class="three" role="group" aria-label="Where the robot begins in the prior map, in the frame of its file">
        ${START.map(([name, words, unit], i) => html`<label>${i === 0 ? (this.store.source === "bridge" ? "Stands at " : "Begins at ") : ""}${words}
          <input type="number" inputmode="decimal" step="any" data-testid="prior-map-${name}" .value=${String(Number(((priorMap.start[i] ?? 0) * unit).toFixed(3)))}
            @change=${(e: Event) => this.#place(priorMap, i, unit, e.target as HTMLInputElement)}></label>`)}
      </div>` : nothing}`;
  }

  /** Whether the robot is localised, for methods that report it. */
  #localisation(): TemplateResult | typeof nothing {
    const { status, source } = this.store;
    const words = status?.localisation ? LOCALISATION_WORDS[status.localisation] : null;
    return html`
      ${words ? html`<p class=${status?.localisation === "localised" ? "" : "bad"} data-testid="localisation">${words}</p>` : nothing}
      ${source === "sim" ? html`<button data-testid="kidnap" title="Carry the robot to a random place, without telling it" @click=${() => this.client.kidnap()}>${icons.hand} Kidnap</button>` : nothing}`;
  }

  #fit(): TemplateResult | typeof nothing {
    const { status } = this.store;
    const isJudged = status !== null && Number.isFinite(status.priorMapOverlap);
    const part = percent(status?.priorMapOverlap ?? NaN);
    const misfit = status?.priorMapMisfit ?? false;
    const words = !isJudged ? "Whether the map fits shows after some scans."
      : misfit && !this.store.setup.priorMap && this.store.source === "sim" ? t`Only ${part} of what the sensor hits is a wall of the map: the robot is elsewhere in it than it believes.`
      : misfit ? t`The map does not fit: only ${part} of what the sensor hits is a wall of it. It shows another building, it is too rough, or the robot is elsewhere in it than it believes.`
      : t`The map fits: ${part} of what the sensor hits is a wall of it.`;
    // An earlier fit means nothing while the robot is lost.
    if (isJudged && !misfit && status.localisation !== null && status.localisation !== "localised") return nothing;
    return html`<p class=${misfit ? "bad" : ""} data-testid="prior-map-fit">${words}</p>`;
  }

  #place(priorMap: PriorMapSetup, index: number, unit: number, input: HTMLInputElement): void {
    const value = Number(input.value || NaN) / unit;
    if (Number.isFinite(value)) {
      const [x, y, heading] = priorMap.start;
      const start = [x, y, heading] as [number, number, number];
      start[index] = value;
      this.client.localiseIn({ ...priorMap, start });
      return;
    }
    // The field shows the start in use again.
    input.value = String(Number(((priorMap.start[index] ?? 0) * unit).toFixed(3)));
  }
}

customElements.define("slam-prior-map", SlamPriorMap);
