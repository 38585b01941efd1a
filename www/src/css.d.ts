// A style sheet imported by a component is its text; see build.mjs.
declare module "uplot/dist/uPlot.min.css" {
  const text: string;
  export default text;
}
