// The part of svgcanvas that we use; the package has no types.

declare module "svgcanvas" {
  interface Drawing extends CanvasRenderingContext2D {
    /** The element that is being painted. */
    readonly __currentElement: SVGElement;
    /** The parent of the next element. */
    __closestGroupOrSvg(): SVGElement;
    getSvg(): SVGSVGElement;
    getSerializedSvg(): string;
  }
  export const Context: new (width: number, height: number) => Drawing;
}
