// The library that plots: a bundle of its own, which comes when the first plot is seen.

export { default } from "uplot";
