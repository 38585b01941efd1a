// What the modules say of themselves: types of all that crosses, and which number stands where in
// flat arrays. Both are made with them. What two modules have is of the one that runs.

export type * from "../../pkg/slamlab_web.js";
export type { Building, GivenFile, ImportedLog, OfferedTopic, RosTopics, SolvedGraph, WorldFault } from "../../pkg/slamlab_files.js";
export type { AdvisedMethod, BasinAsk, CloudPair, MeasuredRow, PairInfo, Registered, RegistrationAdvice, RegistrationOffer } from "../../pkg/slamlab_lab.js";
export * from "../../pkg/layout.js";
