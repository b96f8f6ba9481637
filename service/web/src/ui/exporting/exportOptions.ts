/** Options of an export: the request, the lines for scripts, and the height of the body in the file. Pure functions. */
import { address } from "../../api/client";
import { quoted } from "./arrays";

export interface ExportOptions {
  /** A program ("for") or a format. */
  target: { for: string } | { format: string };
  /** "": as the program wants it, or as in the clip. */
  unit: string;
  up: string;
  fps: number | null;
  /** Metres that the body stands tall; null: as in the clip. */
  height: number | null;
  inPlace: boolean;
  /** A body with a skin, where the format holds one: "own", or the document of a character; "": bones. */
  character: string;
  /** Frames from 1; null: all. */
  range: [number, number] | null;
}

export const UNITS: Record<string, number> = { mm: 0.001, cm: 0.01, m: 1, inch: 0.0254, ft: 0.3048 };

/** The parameters of the request, only those that say something. */
export function queryOf(options: ExportOptions, revision?: number): Record<string, string | number | boolean> {
  const { target, unit, up, fps, height, inPlace, character, range } = options;
  return {
    ...target,
    ...(unit && { unit }),
    ...(up && { up }),
    ...(fps !== null && { fps }),
    ...(height !== null && { height }),
    ...(inPlace && { in_place: true }),
    ...(character && { character }),
    ...(range && { first: range[0], last: range[1] }),
    ...(revision !== undefined && { revision }),
  };
}

/** The body of a request for several clips. */
export const exportClipsBody = (ids: readonly string[], options: ExportOptions) => ({
  selection: { documents: ids },
  ...queryOf(options),
});

export const exportAddress = (id: string, options: ExportOptions, revision?: number): string =>
  address("/documents/{id}/export", { id }, queryOf(options, revision));

const optionOf = (name: string): string => `--${name.replaceAll("_", "-")}`;

/** token: the server needs one, which stands in MCML_TOKEN, and which the command reads. */
export const exportByCommand = (id: string, options: ExportOptions, origin: string): string =>
  exportClipsByCommand([id], options, origin);

export function exportClipsByCommand(ids: readonly string[], options: ExportOptions, origin: string): string {
  const stated = Object.entries(queryOf(options)).map(([name, value]) =>
    value === true ? optionOf(name) : `${optionOf(name)} ${value}`,
  );
  return ["mcml export", ...ids, ...stated, `--server ${origin}`].join(" ");
}

const tokenHeader = (token: boolean): string => (token ? '-H "Authorization: Bearer $MCML_TOKEN" ' : "");

export function exportClipsByCurl(
  ids: readonly string[],
  options: ExportOptions,
  origin: string,
  token: boolean,
): string {
  const body = quoted(JSON.stringify(exportClipsBody(ids, options)));
  return `curl ${tokenHeader(token)}-H "Content-Type: application/json" -d ${body} -o clips.zip ${quoted(origin + address("/exports"))}`;
}

export function exportByCurl(id: string, options: ExportOptions, origin: string, token: boolean): string {
  const header = tokenHeader(token);
  return `curl ${header}-OJ ${quoted(origin + exportAddress(id, options))}`;
}

/** A ruler for a body: its height and marks at round numbers, in the unit of the file. */
export interface Ruler {
  height: number;
  unit: string;
  marks: number[];
}

const MARKS = 5;

/** height: of the standing body, metres. unit: of the file. */
export function rulerOf(height: number, unit: string): Ruler {
  const inUnit = height / (UNITS[unit] ?? 1);
  const power = 10 ** Math.floor(Math.log10(inUnit / MARKS));
  const step = power * ([1, 2, 5, 10].find((one) => inUnit / (power * one) <= MARKS) ?? 10);
  const marks = Array.from({ length: Math.floor(inUnit / step + 1e-9) + 1 }, (_, at) => at * step);
  return { height: inUnit, unit, marks };
}

/** The file's name as the server says it (RFC 6266). */
export function fileNameOf(disposition: string | null, otherwise: string): string {
  const extended = /filename\*=(?:UTF-8|utf-8)''([^;]+)/.exec(disposition ?? "")?.[1];
  if (extended) return decodeURIComponent(extended);
  return /filename="([^"]+)"/.exec(disposition ?? "")?.[1] ?? otherwise;
}
