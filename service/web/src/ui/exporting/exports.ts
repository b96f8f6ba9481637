/** What a document can be exported as, as items of a menu. */
import { address } from "../../api/client";
import { holds, LANGUAGE, presets, writtenFormats, type Format } from "../../state/session/formats";
import type { Item } from "../Menu";
import { number, w } from "../../words";

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
  /** Whether further files of the clip are kept beside its own, if known. */
  beside?: boolean;
  /** Joints whose centres markers tell, if known. */
  centres?: readonly string[];
}

/** What a menu mends. accept: state a guess; give: where unit, up axis and rate are given. Absent: nothing can be written. */
export interface Mending {
  accept?: (fact: { unit?: string; up?: string }) => void;
  give?: () => void;
}

const METRES: Record<string, number> = { mm: 0.001, cm: 0.01, m: 1, inch: 0.0254, ft: 0.3048 };

/** A fact that a format needs and the document does not state: nothing is written without it. */
const factLacking = (one: Exported, { needs, markers }: Pick<Format, "needs" | "markers">): string | null => {
  if (one.markers && !markers && one.centres && !one.centres.includes("left_up_leg")) return w("label.needsPerson");
  if (needs.includes("frame_time") && !one.hasRate) return w("label.needsRate");
  if (needs.includes("force_plates") && !holds(one.format, "force_plates", one.beside)) return w("label.needsPlates");
  if (needs.includes("blend_shapes") && !holds(one.format, "blend_shapes")) return w("label.needsShapes");
  return needs.includes("unit") && !one.unit ? w("label.needsUnit") : null;
};

/** That markers get a skeleton for a format of joints. */
const withSkeleton = ({ markers }: Exported, format: Format): string | undefined =>
  markers && !format.markers ? w("label.skeletonMade") : undefined;

/** What is wrong with a format as long as facts are not known; refused: the server would not write it. */
export function lacking(
  one: Exported,
  { name, needs, assumes, markers }: Pick<Format, "name" | "needs" | "assumes" | "markers">,
): { text: string; refused: boolean } | null {
  if (name === one.format && one.original) return null;
  const fact = factLacking(one, { needs, markers });
  if (fact) return { text: fact, refused: true };
  if (!assumes) return null;
  if (one.unit) return one.up ? null : { text: w("label.upTaken"), refused: false };
  const times = one.likelyUnit ? (METRES[assumes] ?? NaN) / (METRES[one.likelyUnit] ?? NaN) : NaN;
  const size =
    Number.isFinite(times) && Math.abs(times - 1) > 1e-9
      ? w(times > 1 ? "label.tooLarge" : "label.tooSmall", { times: number(times > 1 ? times : 1 / times, 1) })
      : "";
  return { text: [w("label.unitTaken", { as: assumes }), size].filter(Boolean).join(", "), refused: false };
}

export function exportItems(one: Exported, { accept, give }: Mending = {}): Item[] {
  const { id, markers, original, format, revision } = one;
  const others = writtenFormats(markers ? "markers" : "bodies").filter(({ name }) => name !== LANGUAGE);
  const query = revision === undefined ? {} : { revision };
  const guess = (fact: "unit" | "up", value: string | null | undefined): Item[] => {
    if (one[fact]) return [];
    if (value && accept && !value.includes("/"))
      return [
        {
          text: w("button.confirmAs", { value }),
          icon: "warn",
          detail: w(fact === "unit" ? "label.unitGuessed" : "label.upGuessed"),
          run: () => accept({ [fact]: value }),
        },
      ];
    return give && fact === "unit"
      ? [{ text: w("button.giveUnit"), icon: "warn", detail: w("label.unitUnknown"), run: give }]
      : [];
  };
  return [
    ...guess("unit", one.likelyUnit),
    ...guess("up", one.likelyUp),
    ...(!one.hasRate && give
      ? [{ text: w("button.giveRate"), icon: "warn" as const, detail: w("label.rateUnknown"), run: give }]
      : []),
    ...presets(markers ? "markers" : "bodies").map(({ preset, format: other }): Item => {
      const text = w("label.exportFor", { program: preset.title });
      const lack = factLacking(one, other);
      if (lack) return { text, detail: lack, disabled: true };
      return {
        text,
        detail: withSkeleton(one, other) ?? other.label,
        href: address("/documents/{id}/export", { id }, { ...query, for: preset.name }),
        download: true,
      };
    }),
    { text: "MCML", detail: ".mcml", href: address("/documents/{id}/mcml", { id }, query), download: true },
    ...others.map((other): Item => {
      const { name, label: text } = other;
      const lack = lacking(one, other);
      if (lack?.refused) return { text, detail: lack.text, disabled: true };
      return {
        text,
        detail: lack?.text ?? withSkeleton(one, other) ?? (name === format && original ? w("label.kept") : undefined),
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
