// What the page asks of the screen that shows it. Media queries of the style sheets ask the same.

/** A phone, or a window as narrow: panels are sheets over the map. The list tells when that
    changes. */
export function narrowScreen(): MediaQueryList {
  return matchMedia("(max-width: 760px)");
}

export function isNarrow(): boolean {
  return narrowScreen().matches;
}

/** Whether a finger points, and not a mouse. A worker has no screen. */
export function isTouched(): boolean {
  return typeof matchMedia === "function" && matchMedia("(pointer: coarse)").matches;
}
