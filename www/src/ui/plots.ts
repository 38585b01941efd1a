// Curves of the run: position error and heading error with the filter's 3σ, the innovations of the
// matched features, what a scan showed, and time per scan. Without truth there are no errors, and
// only the 3σ are shown.

import { nothing, type TemplateResult } from "lit";
import type { MethodName } from "../protocol/module.js";
import { SAMPLE } from "../protocol/sample.js";
import { word } from "../spoken.js";
import { html, t } from "../words.js";
import { type Curve, SlamCharts } from "./charts.js";

/** For methods without an innovation: the reason, and what they have instead. */
const NO_INNOVATION: Readonly<Partial<Record<MethodName, string>>> = {
  "odometry": "Odometry alone compares nothing with a map: there is no innovation to plot.",
  "scan-matching": "Whole scans are matched, not features: that has a residual, and no innovation with bounds.",
  "grid-particles": "Each particle weighs the whole scan in a map of its own: there is no one innovation to plot.",
  "particle-localisation": "Each particle weighs the whole scan: there is no one innovation to plot.",
  "histogram-localisation": "Every pose of the map weighs the whole scan: there is no one innovation to plot.",
  "prior-map": "Whole scans are matched to the prior map: that has a residual, and no innovation with bounds. By lines neither is kept.",
};

const innovation = (title: string, of: string, unit: string, value: number, bounds: readonly [number, number], colour: string): Curve => ({
  title, meaning: t`Innovation: ${of}, mean of a scan, seen less expected. Of an honest filter 95 of 100 lie between the bounds, as often above 0 as below.`, unit,
  value, bounds, key: "±2σ", digits: 2, colour, isSigned: true,
});

export class SlamPlots extends SlamCharts {
  protected override readonly curves: readonly Curve[] = [
    { title: "Position error", meaning: "Distance between the estimated and the true position, with what the filter claims", unit: "m",
      value: SAMPLE.positionError, bounds: [SAMPLE.positionSigma3], key: "3σ", digits: 3, colour: "estimate",
      boundsAlone: { title: "Position uncertainty", meaning: "What the filter claims, along its most uncertain direction. There is no truth here to hold it against." } },
    { title: "Heading error", meaning: "How far its heading is off, with what the filter claims", unit: "°",
      value: SAMPLE.headingError, bounds: [SAMPLE.headingSigma3], key: "3σ", digits: 2, colour: "truth",
      boundsAlone: { title: "Heading uncertainty", meaning: "What the filter claims. There is no truth here to hold it against." } },
    innovation("Innovation α", "how far recognised walls were turned from where they were expected", "°", SAMPLE.alpha, [SAMPLE.alphaHigh, SAMPLE.alphaLow], "walls"),
    innovation("Innovation r", "how much farther recognised walls were than expected", "cm", SAMPLE.r, [SAMPLE.rHigh, SAMPLE.rLow], "walls"),
    innovation("Innovation of points, ahead", "how much farther ahead recognised points were than expected", "cm", SAMPLE.x, [SAMPLE.xHigh, SAMPLE.xLow], "landmarks"),
    innovation("Innovation of points, left", "how much farther to the left recognised points were than expected", "cm", SAMPLE.y, [SAMPLE.yHigh, SAMPLE.yLow], "landmarks"),
    { title: "Residual of the match", meaning: "Root of the mean squared distance of the scan's points from the surfaces on which they were laid", unit: "mm",
      value: SAMPLE.residual, bounds: [], key: "", digits: 1, colour: "scan" },
    { title: "Features", meaning: "What was found in the scan, what of it is known, and what became a landmark. Where whole scans are matched it is points of surfaces.", unit: "",
      value: SAMPLE.seen, name: word("seen"), bounds: [], key: "", digits: 0, colour: "truth",
      beside: [{ name: word("matched"), value: SAMPLE.matched, colour: "estimate" }, { name: word("new"), value: SAMPLE.new, colour: "path" }] },
    { title: "Time per scan", meaning: "What this computer needs for one scan, planning not counted", unit: "ms",
      value: SAMPLE.scanMillis, bounds: [], key: "", digits: 2, colour: "path" },
  ];

  protected override note(): TemplateResult | typeof nothing {
    const words = NO_INNOVATION[this.store.method];
    return words === undefined ? nothing : html`<p class="none" data-testid="no-innovation">${words}</p>`;
  }
}

customElements.define("slam-plots", SlamPlots);
