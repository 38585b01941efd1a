// The plotting library: a bundle of its own, loaded when the first plot is seen.

export { default } from "uplot";
