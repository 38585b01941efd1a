// How well a map agrees with itself, over run time: for each stretch of the trajectory, the part of
// its walls that agrees with what was seen of them at other times.

import { nothing, type TemplateResult } from "lit";
import { History } from "../history.js";
import { html } from "../words.js";
import { type Curve, SlamCharts } from "./charts.js";

/** The column after the time. */
const AGREEMENT = 1;
/** Seconds between two stretches that count as a pause, not as the time between two scans. */
const PAUSE = 10;

export class SlamAgreement extends SlamCharts {
  protected override readonly topics = ["theme", "run", "quality"] as const;
  protected override readonly names = "quality-plot";
  protected override readonly curves: readonly Curve[] = [
    { title: "Map agrees with itself", meaning: "Of each stretch of the way, the part of its walls that agrees with what was seen of them at other times. Gaps: seen only once.", unit: "%",
      value: AGREEMENT, bounds: [], key: "", digits: 0, colour: "estimate", most: 100 },
  ];
  #history = new History(2);
  #shown: unknown = null;

  protected override get history(): History {
    return this.#history;
  }

  override render(): TemplateResult {
    return this.store.quality ? super.render() : html`${nothing}`;
  }

  override updated(): void {
    const { quality } = this.store;
    if (quality !== this.#shown) {
      this.#shown = quality;
      this.#history.clear();
      let last = NaN;
      for (const { seen: [from, to], agreement } of quality?.overTime ?? []) {
        const percent = agreement === null ? NaN : 100 * agreement;
        // No line is drawn across a pause.
        if (from - last > PAUSE) this.#history.append(Float64Array.of((last + from) / 2, NaN));
        this.#history.append(Float64Array.of(from, percent, to, percent));
        last = to;
      }
    }
    super.updated();
    this.feed();
  }
}

customElements.define("slam-agreement", SlamAgreement);
