// What the page needs to know of its screen. Style sheets use the same media queries.

/** A phone, or an equally narrow window, where panels are sheets over the map. The list reports
    changes. */
export function narrowScreen(): MediaQueryList {
  return matchMedia("(max-width: 760px)");
}

export function isNarrow(): boolean {
  return narrowScreen().matches;
}

/** Whether the pointer is a finger rather than a mouse. A worker has no screen. */
export function isTouched(): boolean {
  return typeof matchMedia === "function" && matchMedia("(pointer: coarse)").matches;
}
