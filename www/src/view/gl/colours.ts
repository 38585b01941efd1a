// CSS colours as four bytes: red, green, blue, alpha.

const known = new Map<string, number>();
/** A context returns every colour that it accepts as #rrggbb or as rgba(…). */
let translator: OffscreenCanvasRenderingContext2D | null = null;

export function wordOf(css: string, alpha: number): number {
  let word = known.get(css);
  if (word === undefined) known.set(css, (word = translated(css)));
  return alpha >= 1 ? word : ((word & 0xffffff) | (Math.round((word >>> 24) * Math.max(alpha, 0)) << 24)) >>> 0;
}

function translated(css: string): number {
  translator ??= new OffscreenCanvas(1, 1).getContext("2d");
  if (!translator) return 0;
  translator.fillStyle = css;
  const said = translator.fillStyle;
  const hex = /^#(..)(..)(..)$/.exec(said);
  const [r = 0, g = 0, b = 0, a = 1] = hex ? hex.slice(1).map((byte) => parseInt(byte, 16)) : (said.match(/[\d.]+/g) ?? []).map(Number);
  return ((Math.round(255 * a) << 24) | (b << 16) | (g << 8) | r) >>> 0;
}
