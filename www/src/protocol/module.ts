// What the module says of itself: types of all that crosses, and which number stands where in flat
// arrays. Both are made with it.

export type * from "../../pkg/slamlab_web.js";
export * from "../../pkg/layout.js";
