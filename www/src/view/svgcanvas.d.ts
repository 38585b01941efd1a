// What we use of svgcanvas, which brings no types.

declare module "svgcanvas" {
  interface Drawing extends CanvasRenderingContext2D {
    /** The element that is being painted. */
    readonly __currentElement: SVGElement;
    /** What the next element goes into. */
    __closestGroupOrSvg(): SVGElement;
    getSvg(): SVGSVGElement;
    getSerializedSvg(): string;
  }
  export const Context: new (width: number, height: number) => Drawing;
}
