/** Results as files: tables and arrays of the service, and the plots as one picture. */
import { address, fetched } from "../../api/client";
import { colour } from "../../state/session/settings";
import { saveBlob } from "../../ui/exporting/saveBlob";
import { BOX } from "./chart";
import type { requestOf } from "./request";

export const FORMS = ["csv", "parquet", "npz"] as const;
export type Form = (typeof FORMS)[number];

const GAP = 16;
const CAPTION = 18;
const COLUMNS = 3;

/** Fetch all rows in a form and save them. */
export async function saveTable(request: NonNullable<ReturnType<typeof requestOf>>, form: Form): Promise<void> {
  const answer = await fetched(address("/measure"), {
    method: "POST",
    headers: { "content-type": "application/json" },
    body: JSON.stringify({ ...request, as: form }),
  });
  saveBlob(await answer.blob(), `measures.${form}`);
}

/** Save the plots of a page, with their captions, in three columns. */
export function savePlots(plots: HTMLElement): void {
  const figures = [...plots.querySelectorAll("figure")];
  const columns = Math.min(COLUMNS, figures.length);
  const [wide, high] = [BOX.width + GAP, BOX.height + CAPTION + GAP];
  const text = new XMLSerializer();
  const parts = figures.map((figure, at) => {
    const svg = figure.querySelector("svg");
    const picture = svg?.cloneNode(true) as SVGSVGElement;
    const [x, y] = [(at % columns) * wide + GAP / 2, Math.floor(at / columns) * high + GAP / 2];
    picture.setAttribute("x", String(x));
    picture.setAttribute("y", String(y + CAPTION));
    picture.setAttribute("width", String(BOX.width));
    picture.setAttribute("height", String(BOX.height));
    const caption = document.createElementNS("http://www.w3.org/2000/svg", "text");
    caption.setAttribute("x", String(x + 4));
    caption.setAttribute("y", String(y + 12));
    caption.setAttribute("fill", colour("text"));
    caption.textContent = (figure.querySelector("figcaption")?.innerText ?? "").replaceAll(/\s+/g, " ");
    return text.serializeToString(caption) + text.serializeToString(picture);
  });
  const [width, height] = [columns * wide, Math.ceil(figures.length / columns) * high];
  const whole =
    `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" ` +
    `font-family="sans-serif" font-size="11"><rect width="100%" height="100%" fill="${colour("bg")}"/>` +
    `${parts.join("")}</svg>`;
  saveBlob(new Blob([whole], { type: "image/svg+xml" }), "measures.svg");
}
