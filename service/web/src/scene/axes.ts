/** The world's axes in the corner of a picture. */
import * as THREE from "three";

const depth = (axis: THREE.Vector3, camera: THREE.Camera): number =>
  -axis.clone().transformDirection(camera.matrixWorldInverse).z;

/** x0, y0: the middle. zUp: whether the clip's Z points up. */
export function drawAxes(
  pen: CanvasRenderingContext2D,
  camera: THREE.Camera,
  token: (name: string) => string,
  x0: number,
  y0: number,
  zUp: boolean,
): void {
  const axes: [string, THREE.Vector3][] = zUp
    ? [
        ["x", new THREE.Vector3(1, 0, 0)],
        ["y", new THREE.Vector3(0, 0, -1)],
        ["z", new THREE.Vector3(0, 1, 0)],
      ]
    : [
        ["x", new THREE.Vector3(1, 0, 0)],
        ["y", new THREE.Vector3(0, 1, 0)],
        ["z", new THREE.Vector3(0, 0, 1)],
      ];
  pen.textAlign = "center";
  for (const [name, axis] of axes.sort((a, b) => depth(b[1], camera) - depth(a[1], camera))) {
    const seen = axis.clone().transformDirection(camera.matrixWorldInverse);
    const [x, y] = [x0 + seen.x * 20, y0 - seen.y * 20];
    pen.strokeStyle = pen.fillStyle = token(name);
    pen.lineWidth = 2;
    pen.beginPath();
    pen.moveTo(x0, y0);
    pen.lineTo(x, y);
    pen.stroke();
    pen.fillText(name.toUpperCase(), x0 + seen.x * 30, y0 - seen.y * 30);
  }
  pen.textAlign = "start";
}
