/** What a document can be exported as, as items of a menu. */
import { signal } from "@preact/signals";
import { address, get } from "../../api/client";
import type { Item } from "../Menu";
import { number, w } from "../../words";

/** A format with the name that people know it by. */
type Named = readonly [format: string, name: string];

const BODY_FORMATS: Named[] = [
  ["bvh", "BVH"],
  ["asf-amc", "ASF/AMC"],
  ["htr", "HTR"],
];
const MARKER_FORMATS: Named[] = [
  ["c3d", "C3D"],
  ["trc", "TRC"],
];
const SCENES: Named[] = [
  ["glb", "glTF"],
  ["usd", "USD"],
];
const ANGLES: Named[] = [["mot", "OpenSim"]];

/** Formats that this server cannot write: not every one has the library. USD, until it is known. */
export const unwritable = signal<ReadonlySet<string>>(new Set(["usd"]));
let asked = false;

/** Ask once what the server writes. */
export function askWritable(): void {
  if (asked) return;
  asked = true;
  get("/formats").then(
    (list) => {
      unwritable.value = new Set(list.items.filter((one) => !one.writes).map((one) => one.name));
    },
    () => {
      asked = false;
    },
  );
}

/** A document as its menu needs it: what is stated of unit, up axis and rate, and what is guessed instead. */
export interface Exported {
  id: string;
  markers: boolean;
  /** Whether its kept file is what an export to its own format gives. */
  original: boolean;
  format: string;
  revision?: number;
  unit: string | null;
  likelyUnit?: string | null;
  up: string | null;
  likelyUp?: string | null;
  hasRate: boolean;
}

/** What a menu mends. accept: state a guess; give: where unit, up axis and rate are given. Absent: nothing can be written. */
export interface Mending {
  accept?: (fact: { unit?: string; up?: string }) => void;
  give?: () => void;
}

const METRES: Record<string, number> = { mm: 0.001, cm: 0.01, m: 1, inch: 0.0254, ft: 0.3048 };
const NEEDS_RATE = new Set(["bvh", "c3d", "trc", "glb", "usd", "mot"]);
const NEEDS_UNIT = new Set(["trc"]);
/** What programs take the numbers as where no unit is stated, metres. */
const TAKEN_AS: Record<string, [string, number]> = { glb: ["m", 1], usd: ["cm", 0.01] };

/** What is wrong with a format as long as facts are not known; refused: the server would not write it. */
export function lacking(one: Exported, name: string): { text: string; refused: boolean } | null {
  if (name === one.format && one.original) return null;
  if (NEEDS_RATE.has(name) && !one.hasRate) return { text: w("needsRate"), refused: true };
  if (NEEDS_UNIT.has(name) && !one.unit) return { text: w("needsUnit"), refused: true };
  const taken = TAKEN_AS[name];
  if (!taken || one.unit) return taken && !one.up ? { text: w("upTaken"), refused: false } : null;
  const [as, metres] = taken;
  const times = one.likelyUnit ? metres / (METRES[one.likelyUnit] ?? NaN) : NaN;
  const size =
    Number.isFinite(times) && Math.abs(times - 1) > 1e-9
      ? w(times > 1 ? "tooLarge" : "tooSmall", { times: number(times > 1 ? times : 1 / times, 1) })
      : "";
  return { text: [w("unitTaken", { as }), size].filter(Boolean).join(", "), refused: false };
}

export function exportItems(one: Exported, { accept, give }: Mending = {}): Item[] {
  askWritable();
  const { id, markers, original, format, revision } = one;
  const formats = [...(markers ? MARKER_FORMATS : BODY_FORMATS), ...SCENES, ...(markers ? [] : ANGLES)].filter(
    ([name]) => !unwritable.value.has(name),
  );
  const query = revision === undefined ? {} : { revision };
  const guess = (fact: "unit" | "up", value: string | null | undefined): Item[] => {
    if (one[fact]) return [];
    if (value && accept && !value.includes("/"))
      return [
        {
          text: w("confirmAs", { value }),
          icon: "warn",
          detail: w(fact === "unit" ? "unitGuessed" : "upGuessed"),
          run: () => accept({ [fact]: value }),
        },
      ];
    return give && fact === "unit" ? [{ text: w("giveUnit"), icon: "warn", detail: w("unitUnknown"), run: give }] : [];
  };
  return [
    ...guess("unit", one.likelyUnit),
    ...guess("up", one.likelyUp),
    ...(!one.hasRate && give
      ? [{ text: w("giveRate"), icon: "warn" as const, detail: w("rateUnknown"), run: give }]
      : []),
    { text: "MCML", detail: ".mcml", href: address("/documents/{id}/mcml", { id }, query), download: true },
    ...formats.map(([name, text]): Item => {
      const lack = lacking(one, name);
      if (lack?.refused) return { text, detail: lack.text, disabled: true };
      return {
        text,
        detail: lack?.text ?? (name === format && original ? w("kept") : undefined),
        href: address("/documents/{id}/export", { id }, { ...query, format: name }),
        download: true,
      };
    }),
    {
      text: "CSV",
      detail: ".csv",
      href: address("/documents/{id}/frames", { id }, { ...query, format: "csv" }),
      download: true,
    },
    {
      text: "NumPy",
      detail: ".npz",
      href: address("/documents/{id}/frames", { id }, { ...query, format: "npz" }),
      download: true,
    },
  ];
}
