/** What is drawn in two dimensions over the stage: rings and names of joints. */
import { isGuess, type Skeleton } from "../motion/body/skeleton";

const MOST_NAMED = 4; // selected joints: more names would cover one another

/** The joints to mark: all names, those selected, the one under the pointer (-1: none). */
export interface Marked {
  names: boolean;
  selected: ReadonlySet<number>;
  hovered: number;
}

/** The pen of an empty overlay, in CSS pixels. */
export function cleared(overlay: HTMLCanvasElement, width: number, height: number): CanvasRenderingContext2D {
  const pen = overlay.getContext("2d")!;
  const ratio = overlay.width / Math.max(1, width);
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  return pen;
}

export function drawJoints(
  pen: CanvasRenderingContext2D,
  skeleton: Skeleton,
  { names, selected, hovered }: Marked,
  placeOf: (point: number) => { x: number; y: number } | null,
  token: (name: string) => string,
): void {
  pen.textBaseline = "middle";
  skeleton.view.bones.forEach((bone, point) => {
    const chosen = selected.has(point);
    if (!names && !chosen && point !== hovered) return;
    const at = placeOf(point);
    if (!at) return;
    if (chosen || point === hovered) {
      pen.lineWidth = 2;
      pen.strokeStyle = token(chosen ? "select" : "accent");
      pen.beginPath();
      pen.arc(at.x, at.y, 9, 0, Math.PI * 2);
      pen.stroke();
    }
    if (!names && point !== hovered && selected.size > MOST_NAMED) return;
    pen.lineWidth = 3;
    pen.strokeStyle = token("well");
    pen.strokeText(bone.name, at.x + 14, at.y);
    // Guessed names and joints without one differ from sure names.
    const ink = isGuess(bone) ? "warn" : bone.mapped === false ? "text3" : "text2";
    pen.fillStyle = token(chosen ? "select" : ink);
    pen.fillText(bone.name, at.x + 14, at.y);
  });
}

/** The stage with its overlay as a PNG. */
export function pictureOf(canvas: HTMLCanvasElement, overlay: HTMLCanvasElement): Promise<Blob> {
  const both = document.createElement("canvas");
  both.width = canvas.width;
  both.height = canvas.height;
  const pen = both.getContext("2d")!;
  pen.drawImage(canvas, 0, 0);
  pen.drawImage(overlay, 0, 0, both.width, both.height);
  return new Promise((resolve) => both.toBlob((blob) => resolve(blob!), "image/png"));
}
