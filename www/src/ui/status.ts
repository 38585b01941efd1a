// The current figures.

import { css, type TemplateResult } from "lit";
import { degrees } from "../angle.js";
import { word } from "../spoken.js";
import { html, t } from "../words.js";
import { SlamElement } from "./element.js";
import { figure, figures } from "./figures.js";
import { clock, DASH, fixed, length } from "./format.js";

export class SlamStatus extends SlamElement {
  static override styles = [
    figures,
    css`
      h2 { margin-bottom: 12px; }
      .big { display: grid; grid-template-columns: 1fr 1fr; gap: 8px; margin-bottom: 12px; }
      .big div { padding: 10px 12px; border-radius: 12px; background: var(--sunk); border: 1px solid var(--line); }
      .big b { display: block; font: 500 25px/1.15 var(--mono); letter-spacing: -.03em; white-space: nowrap; }
      .big b small { font-size: 14px; color: var(--muted); margin-left: 3px; }
      .big span { font-size: 12px; color: var(--muted); }
      meter { display: block; appearance: none; width: 100%; height: 4px; margin-top: 7px; border: 0; border-radius: 2px; overflow: hidden; background: var(--line); }
      meter::-webkit-meter-bar { background: var(--line); border: 0; height: 4px; border-radius: 2px; }
      meter::-webkit-meter-optimum-value { background: var(--accent); }
      meter::-moz-meter-bar { background: var(--accent); }
    `,
  ];

  protected override readonly topics = ["frame", "run"] as const;

  override render(): TemplateResult {
    const s = this.store.status;
    const sim = this.store.source === "sim";
    const error = length(s?.positionError ?? NaN);
    const wheels = length(s?.odometryError ?? NaN);
    return html`
      <h2>Status</h2>
      <div class="big">
        ${this.store.source === "bridge"
          ? html`<div><b data-testid="scans">${s?.scans ?? DASH}</b><span>scans mapped</span></div>
            <div><b>${fixed(s?.distance ?? NaN, 1)}<small>m</small></b><span>driven</span></div>`
          : sim
          ? html`<div title="Part of the reachable area that the map knows"><b data-testid="explored">${whole(s?.explored)}<small>%</small></b><span>explored</span>
              <meter max="1" .value=${finite(s?.explored)} aria-label="explored"></meter></div>
            <div title="Distance between the estimated and the true position"><b data-testid="position-error">${error.value}<small>${error.unit}</small></b><span>position error</span><br><span>wheels alone ${wheels.value} ${wheels.unit}</span></div>`
          : html`<div><b data-testid="progress-percent">${whole(s?.progress)}<small>%</small></b><span>of the recording</span><meter max="1" .value=${finite(s?.progress)} aria-label="progress"></meter></div>
            <div><b data-testid="scans">${s?.scans ?? DASH}</b><span>scans mapped</span></div>`}
      </div>
      <dl>
        ${figure(sim ? "Sim time" : this.store.source === "bridge" ? "Robot time" : "Log time", clock(s?.time ?? NaN), "time")}
        ${this.store.source === "bridge" ? "" : figure("Pace", Number.isFinite(s?.realTimeFactor) ? `${fixed(s?.realTimeFactor ?? NaN, (s?.realTimeFactor ?? 0) < 10 ? 1 : 0)} ×` : word("paused"), "pace", "Seconds of simulation for each second of the clock")}
        ${figure("Distance", `${fixed(s?.distance ?? NaN, 1)} m`, "distance")}
        ${s && s.features > 0 ? figure("Features", String(s.features), "features", "Lines in the filter's map") : ""}
        ${figure("Known", `${fixed(s?.knownArea ?? NaN, 0)} m²`, "known-area", "Area known to be free")}
        ${sim ? figure("Contacts", fixed(s?.contacts ?? NaN, 0), "contacts", "How often the robot touched a wall") : ""}
        ${figure("Scans", String(s?.scans ?? DASH), sim ? "scans" : "scans-row")}
        ${s && s.mapParticles > 0 ? figure("Particles", t`${s.mapParticles}, ${fixed(s.effectiveParticles, 1)} effective`, "particles",
          "Each has a map of its own. So many of equal weight would estimate as well: where too few are effective, they are drawn anew", "wide") : ""}
        ${sim ? figure("Heading error", `${fixed(Math.abs(degrees(s?.headingError ?? NaN)), 1)}° (3σ ${claimed(3 * Math.sqrt(s?.covHeading ?? NaN))})`, "heading-error",
          "How far its heading is off now, and the 3σ that the filter claims. Tracks slip in a turn: by a degree or two until the next scan shows it", "wide") : ""}
        ${figure("State hash", this.store.hash || DASH, "hash", "A fingerprint of the whole state. The same run gives the same one here and on the command line.", "wide")}
      </dl>
    `;
  }
}

/** The bound of a heading, rad: half a turn means that nothing is known. */
function claimed(bound: number): string {
  return bound >= Math.PI ? "over 180°" : `${fixed(degrees(bound), 1)}°`;
}

function whole(fraction: number | undefined): string {
  return Number.isFinite(fraction) ? String(Math.floor((fraction ?? 0) * 100)) : DASH;
}

function finite(value: number | undefined): number {
  return value !== undefined && Number.isFinite(value) ? value : 0;
}

customElements.define("slam-status", SlamStatus);
