// What the twin did since it was last asked, in the units of the page.

import type { WebLive, WebReplay } from "../../pkg/slamlab_web.js";
import { TWIN, TWIN_STRIDE } from "../protocol/module.js";

const DEGREES = 180 / Math.PI;

export class TwinFeed {
  #told = 0;

  /** The samples that are new; null where there are none. */
  take(module: WebLive | WebReplay): Float64Array | null {
    const samples = module.twin_since(this.#told);
    if (samples.length === 0) return null;
    this.#told += samples.length / TWIN_STRIDE;
    for (let i = 0; i < samples.length; i += TWIN_STRIDE) {
      samples[i + TWIN.headingOff] = Math.abs(samples[i + TWIN.headingOff] ?? NaN) * DEGREES;
      samples[i + TWIN.headingSigma3] = (samples[i + TWIN.headingSigma3] ?? NaN) * DEGREES;
    }
    return samples;
  }

  /** Another twin begins. */
  again(): void {
    this.#told = 0;
  }
}
