/** The middle of the joints that are there, in the unit and axes of the positions; null where none is. */
export function middleOf(positions: Float32Array, joints: number): [number, number, number] | null {
  const sum: [number, number, number] = [0, 0, 0];
  let count = 0;
  for (let joint = 0; joint < joints; joint++) {
    const [x, y, z] = [positions[joint * 3]!, positions[joint * 3 + 1]!, positions[joint * 3 + 2]!];
    if (x !== x || y !== y || z !== z) continue;
    sum[0] += x;
    sum[1] += y;
    sum[2] += z;
    count++;
  }
  return count ? [sum[0] / count, sum[1] / count, sum[2] / count] : null;
}
