// The contents of the tabs of filter, paths and settings, and of the fold with submaps and other
// maps: a bundle of its own. Its components have their places in index.html (main.ts puts them
// there) and in the fold (maps.ts), and become active when they are defined.

import "./calibration.js";
import "./consistency.js";
import "./contest.js";
import "./correlations.js";
import "./fit.js";
import "./matches.js";
import "./pose_graph.js";
import "./prior_map.js";
import "./saved_map.js";
import "./settings.js";
import "./sigma.js";
import "./submaps.js";
