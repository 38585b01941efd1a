// Curves of the run: position error and heading error with the 3σ that the filter claims, and time
// per scan. Without truth there are no errors, and the claims stand alone.

import { SAMPLE } from "../protocol/sample.js";
import { type Curve, SlamCharts } from "./charts.js";

export class SlamPlots extends SlamCharts {
  protected override readonly curves: readonly Curve[] = [
    { title: "Position error", meaning: "Distance between the estimated and the true position, with what the filter claims", unit: "m",
      value: SAMPLE.positionError, bounds: [SAMPLE.positionSigma3], key: "3σ", digits: 3, colour: "estimate",
      boundsAlone: { title: "Position uncertainty", meaning: "What the filter claims, along its most uncertain direction. There is no truth here to hold it against." } },
    { title: "Heading error", meaning: "How far its heading is off, with what the filter claims", unit: "°",
      value: SAMPLE.headingError, bounds: [SAMPLE.headingSigma3], key: "3σ", digits: 2, colour: "truth",
      boundsAlone: { title: "Heading uncertainty", meaning: "What the filter claims. There is no truth here to hold it against." } },
    { title: "Time per scan", meaning: "What this computer needs for one scan, planning not counted", unit: "ms",
      value: SAMPLE.scanMillis, bounds: [], key: "", digits: 2, colour: "path" },
  ];
}

customElements.define("slam-plots", SlamPlots);
