// An element over the page takes the files that are dropped on it: the page behind gets none.

/** Passes files dropped on `element` to `open`. */
export function takeDrops(element: HTMLElement, open: (files: File[]) => void): void {
  const keep = (event: DragEvent): void => {
    event.preventDefault();
    event.stopPropagation();
  };
  for (const kind of ["dragenter", "dragover", "dragleave"] as const) element.addEventListener(kind, keep);
  element.addEventListener("drop", (event) => {
    keep(event);
    open([...(event.dataTransfer?.files ?? [])]);
  });
}
