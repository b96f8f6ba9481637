/** The formats of this server: what it reads and writes, and what each holds and needs. Asked once a visit. */
import { signal } from "@preact/signals";
import { get, type Schemas } from "../../api/client";

export type Format = Schemas["FormatInfo"];
export type Preset = Schemas["PresetInfo"];

/** The language of the repository, which every clip can be written in. */
export const LANGUAGE = "mcml";
export const archives: readonly string[] = [".zip", ".7z", ".tar", ".tgz", ".gz"];

const known = signal<readonly Format[]>([]);
const programs = signal<readonly Preset[]>([]);
let asked = false;

/** All, as the server lists them; none until it has answered. */
export function formats(): readonly Format[] {
  if (!asked) {
    asked = true;
    get("/formats").then(
      (list) => {
        known.value = list.items;
        programs.value = list.presets;
      },
      () => (asked = false),
    );
  }
  return known.value;
}

/** Those that are read, the language first. */
export function readFormats(): Format[] {
  const read = formats().filter((one) => one.reads);
  return [...read.filter((one) => one.name === LANGUAGE), ...read.filter((one) => one.name !== LANGUAGE)];
}

/** Those that are written, the language first. holds: only those for clips of bodies, or of markers, which make a
 * skeleton for the formats of bodies. */
export function writtenFormats(holds?: "bodies" | "markers"): Format[] {
  const written = formats().filter((one) => one.writes && (holds !== "bodies" || one.bodies));
  return [...written.filter((one) => one.name === LANGUAGE), ...written.filter((one) => one.name !== LANGUAGE)];
}

/** The programs that clips are exported for, each with the format that it gets; only formats that are written. */
export function presets(holds: "bodies" | "markers"): { preset: Preset; format: Format }[] {
  const written = writtenFormats(holds);
  return programs.value.flatMap((preset) => {
    const format = written.find((one) => one.name === preset[holds].format);
    return format ? [{ preset, format }] : [];
  });
}

export const isOneFile = (format: Format): boolean => format.parts.length === 1;

/** The extension of a written file, with its point; formats of several files come as a zip. */
export const extensionOf = (format: Format): string =>
  (isOneFile(format) ? format.parts[0]?.extensions[0] : undefined) ?? ".zip";

/** The name that people know a format by. */
export const labelOf = (name: string): string =>
  formats().find((one) => one.name === name)?.label ?? name.toUpperCase();

/** Whether files of a format hold a fact. beside: whether there are further files of the clip. */
export const holds = (name: string, fact: string, beside = false): boolean =>
  formats().some(
    (one) => one.name === name && (one.states.includes(fact) || (beside && one.states_beside.includes(fact))),
  );

const extensionsOf = (some: readonly Format[]): string[] =>
  some.filter((one) => one.reads).flatMap((one) => one.extensions);

const ends = (name: string, extensions: string[]): boolean =>
  extensions.some((extension) => name.toLowerCase().endsWith(extension));

/** The format whose clips a file of this name may belong to beside their own, such as a buffer of glTF. */
export const formatBeside = (name: string): Format | undefined => formats().find((one) => ends(name, one.beside));

/** Whether a file of this name holds clips of a format. */
export const isOf = (name: string, format: Format): boolean => ends(name, format.extensions);

/** Extensions of the files that can be uploaded, archives too; none until the server has answered. */
export function readExtensions(): string[] {
  const found = [...extensionsOf(formats()), ...formats().flatMap((one) => one.beside)];
  return found.length ? [...found, ...archives] : [];
}

/** Whether a file of this name is of a kind that is read. */
export const isRead = (name: string): boolean => ends(name, readExtensions());

/** Whether a file of this name is one clip by itself. */
export const isOneClip = (name: string): boolean =>
  ends(name, extensionsOf(formats().filter((one) => isOneFile(one) && !one.takes)));
