// Where the axis of a curve ends: a few values far beyond all others do not flatten the rest.

/** So many of the values may lie beyond the end, */
const PART = 0.01;
/** if with them the axis would be so many times as long. */
const TIMES = 4;

/** The largest of `columns` from 0 on, without what is rare and far beyond; signs do not count.
    Only the values from `first` to `last` are looked at; those of no number are none. */
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
