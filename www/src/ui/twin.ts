// Curves of the twin: its distance from the robot, with the bound that chance allows.

import { css, type TemplateResult } from "lit";
import type { History } from "../history.js";
import { TWIN } from "../protocol/module.js";
import { html } from "../words.js";
import { type Curve, SlamCharts } from "./charts.js";

export class SlamTwin extends SlamCharts {
  static override styles = [SlamCharts.styles, css`:host([hidden]) { display: none; } p { margin: 0 0 8px; font-size: 12.5px; line-height: 1.5; color: var(--muted); }`];

  protected override readonly curves: readonly Curve[] = [
    { title: "Twin: position", meaning: "Distance from the simulated twin to where the robot is believed to be, with what chance allows", unit: "m",
      value: TWIN.positionOff, bounds: [TWIN.positionSigma3], key: "3σ", digits: 3, colour: "twin" },
    { title: "Twin: heading", meaning: "How far the twin's heading is off, with what chance allows", unit: "°",
      value: TWIN.headingOff, bounds: [TWIN.headingSigma3], key: "3σ", digits: 2, colour: "twin" },
    { title: "Twin: ranges", meaning: "Median difference between the ranges measured and those that the twin would measure in the map; half a cell is as good as none", unit: "m",
      value: TWIN.ranges, bounds: [], key: "", digits: 3, colour: "twin" },
  ];
  protected override readonly names = "twin";

  protected override get history(): History {
    return this.store.twin;
  }

  override render(): TemplateResult {
    this.toggleAttribute("hidden", !this.store.tuning.twin);
    return html`<h2>Twin</h2><p>A simulated robot with the same motion of the wheels. Within 3σ of chance it behaves as the robot does; where it leaves the band, or chance is told to be far more than is seen, its figures are not the robot's: fit them in Settings.</p>${super.render()}`;
  }
}

customElements.define("slam-twin", SlamTwin);
