/** Quaternions x y z w as plain arrays; conventions of the repository: docs/conventions.md. */
import { numberAt } from "../../lists";
export type Quaternion = [number, number, number, number];
export type Vector = [number, number, number];

export const IDENTITY: Quaternion = [0, 0, 0, 1];

export function multiply(a: Quaternion, b: Quaternion): Quaternion {
  const [ax, ay, az, aw] = a;
  const [bx, by, bz, bw] = b;
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

export const inverse = ([x, y, z, w]: Quaternion): Quaternion => [-x, -y, -z, w];

export function rotate([x, y, z, w]: Quaternion, [vx, vy, vz]: Vector): Vector {
  const tx = 2 * (y * vz - z * vy);
  const ty = 2 * (z * vx - x * vz);
  const tz = 2 * (x * vy - y * vx);
  return [vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx];
}

export function about(axis: string, radians: number): Quaternion {
  const half = Math.sin(radians / 2);
  const place = "XYZ".indexOf(axis.toUpperCase());
  const found: Quaternion = [0, 0, 0, Math.cos(radians / 2)];
  found[place] = half;
  return found;
}

/** Turns in the order of the letters, each about the axes that the ones before have turned: R = R1 R2 R3. */
export const turning = (order: string, radians: number[]): Quaternion =>
  [...order].reduce<Quaternion>((done, axis, index) => multiply(done, about(axis, numberAt(radians, index))), IDENTITY);

/** Turns in the order of the letters about axes that stay: R = R3 R2 R1. */
export const fixed = (order: string, radians: number[]): Quaternion =>
  [...order].reduce<Quaternion>((done, axis, index) => multiply(about(axis, numberAt(radians, index)), done), IDENTITY);
