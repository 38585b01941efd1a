// The end of a curve's axis: a few values far beyond all others must not flatten the rest.

/** This part of the values may lie beyond the end, */
const PART = 0.01;
/** if the axis would otherwise be longer by this factor. */
const TIMES = 4;

/** The largest absolute value in `columns`, without rare ones far beyond the others. Only the
    values from `first` to `last` count; those that are no finite number are skipped. */
export function axisEnd(columns: readonly ArrayLike<number | null | undefined>[], first: number, last: number): number {
  const values: number[] = [];
  for (const column of columns) {
    for (let i = first; i <= last; i += 1) {
      const value = column[i];
      if (value !== null && value !== undefined && Number.isFinite(value)) values.push(Math.abs(value));
    }
  }
  let end = values.reduce((most, value) => Math.max(most, value), 0);
  for (;;) {
    const bound = end / TIMES;
    const [beyond, rest] = values.reduce(([count, most], value) => (value > bound ? [count + 1, most] : [count, Math.max(most, value)]), [0, 0]);
    if (rest === 0 || beyond > PART * values.length) return end;
    end = rest;
  }
}
