// What the page has to know of a method besides its name.

import type { MethodName } from "./module.js";

/** Whether a method needs a prior map. */
const NEEDS_PRIOR_MAP: Record<MethodName, boolean> = {
  "odometry": false,
  "line-ekf": false,
  "scan-matching": false,
  "grid-particles": false,
  "prior-map": true,
  "particle-localisation": true,
  "histogram-localisation": true,
};

export const needsPriorMap = (method: MethodName): boolean => NEEDS_PRIOR_MAP[method];
