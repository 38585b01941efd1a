// Reads what a person entered into a field.

/** The value of the input or list that changed. */
export function valueOf({ target }: Event): string {
  return (target as HTMLInputElement | HTMLSelectElement | HTMLTextAreaElement).value;
}

export function isChecked({ target }: Event): boolean {
  return (target as HTMLInputElement).checked;
}

/** The files that were chosen; the same ones can be chosen again. */
export function filesOf({ target }: Event): File[] {
  const input = target as HTMLInputElement;
  const files = [...(input.files ?? [])];
  input.value = "";
  return files;
}
