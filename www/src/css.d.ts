// A style sheet that a component imports is text; see build.mjs.
declare module "uplot/dist/uPlot.min.css" {
  const text: string;
  export default text;
}
