// Columns as CSV (RFC 4180): UTF-8, units in the header, a decimal point.

export interface Column {
  readonly title: string;
  /** Empty if the number has no unit. */
  readonly unit: string;
  readonly values: ArrayLike<number | string>;
}

/** A row for each value of the first column; numbers that are not finite are left empty. */
export function csvOf(columns: readonly Column[]): string {
  const header = columns.map(({ title, unit }) => quoted(unit === "" ? title : `${title} (${unit})`));
  const rows = Array.from({ length: columns[0]?.values.length ?? 0 }, (_, row) =>
    columns.map(({ values }) => cellOf(values[row])));
  return [header, ...rows].map((cells) => `${cells.join(",")}\r\n`).join("");
}

function cellOf(value: number | string | undefined): string {
  if (typeof value === "string") return quoted(value);
  return Number.isFinite(value) ? String(value) : "";
}

function quoted(text: string): string {
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
