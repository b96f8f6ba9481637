/** Amounts of bytes, in decimal units as disks have them. */
import { language } from "../../state/session/settings";

export const UNITS = { megabyte: 1e6, gigabyte: 1e9, terabyte: 1e12 } as const;
export type Unit = keyof typeof UNITS;

/** 1.2 GB; bytes and kilobytes below. */
export function size(bytes: number): string {
  const [unit, one] =
    bytes < 1e3
      ? ["byte", 1]
      : bytes < 1e6
        ? ["kilobyte", 1e3]
        : ([...Object.entries(UNITS)].reverse().find(([, each]) => bytes >= each) as [string, number]);
  return new Intl.NumberFormat(language.value, {
    style: "unit",
    unit,
    unitDisplay: unit === "byte" ? "long" : "short",
    maximumFractionDigits: bytes < 10 * one && one > 1 ? 1 : 0,
  }).format(bytes / one);
}

/** The unit in which an amount is a short number. */
export const unitOf = (bytes: number): Unit =>
  bytes % 1e12 === 0 ? "terabyte" : bytes % 1e9 === 0 ? "gigabyte" : "megabyte";
export const unitName = (unit: Unit): string => ({ megabyte: "MB", gigabyte: "GB", terabyte: "TB" })[unit];
