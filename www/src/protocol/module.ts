// Generated with the modules: the types of all messages, and the layout of flat arrays. What two
// modules share is taken from the one that runs.

export type * from "../../pkg/slamlab_web.js";
export type { Building, GivenFile, ImportedLog, OfferedTopic, RosTopics, SolvedGraph, WorldFault } from "../../pkg/slamlab_files.js";
export type { AdvisedMethod, BasinAsk, CloudPair, MeasuredRow, PairInfo, Registered, RegistrationAdvice, RegistrationOffer } from "../../pkg/slamlab_lab.js";
export * from "../../pkg/layout.js";
