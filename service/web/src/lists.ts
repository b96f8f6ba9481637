/** Reading from lists and tables, where an index or key may be outside. */

/** The number at an index; NaN outside of the list, which spreads as a missing sample does. */
export const numberAt = (list: ArrayLike<number>, index: number): number => list[index] ?? NaN;

/** The item at an index. RangeError outside of the list: a fault of the caller. */
export function itemAt<T>(list: ArrayLike<T>, index: number): T {
  if (!(index >= 0 && index < list.length)) throw new RangeError(`There is no item ${index} among ${list.length}.`);
  return list[index] as T;
}

/** The value of a key. RangeError for a key that is not there: a fault of the caller. */
export function entryOf<T>(table: Readonly<Record<string, T>>, key: string): T {
  if (!Object.hasOwn(table, key)) throw new RangeError(`There is no entry ${key}.`);
  return table[key] as T;
}
