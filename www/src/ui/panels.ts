// What the tabs of filter, paths and settings show: a bundle of its own. index.html has a place for
// each component, and main.ts has put it there; it comes to life when it is defined.

import "./calibration.js";
import "./consistency.js";
import "./contest.js";
import "./correlations.js";
import "./fit.js";
import "./matches.js";
import "./settings.js";
import "./sigma.js";
