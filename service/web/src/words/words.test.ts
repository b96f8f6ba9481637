// @vitest-environment happy-dom
import { entryOf, itemAt } from "../lists";
import { describe, expect, it } from "vitest";
import { type Language, language, languages } from "../state/session/settings";
import { duration, rate, w, when } from ".";
import { en } from "./en";
import { ja } from "./ja";
import { ko } from "./ko";

const holes = (text: string) => [...new Set(text.match(/\{\w+\}/g) ?? [])].sort();

type Table = Record<string, string>;
type Tables = Record<Language, Table>;
const panels = import.meta.glob<Record<string, Tables>>("../{panels,ui}/*/words.ts", { eager: true });
const sources = Object.values(
  import.meta.glob<string>(
    ["../**/*.{ts,tsx}", "../../pages.json", "!../**/*.test.*", "!./{en,ko,ja}.ts", "!../**/words.ts"],
    {
      eager: true,
      query: "?raw",
      import: "default",
    },
  ),
).join("\n");
const parts = (pattern: RegExp) => [...new Set([...sources.matchAll(pattern)].map((match) => match[1] ?? ""))];
const quoted = new Set(parts(/["'`]([\w.-]+)["'`]/g));
/** Beginnings and ends of keys that are made of a value: `label.did_${what}`, `label.${support}Data`. The value
 * of `label.${support}` itself is quoted somewhere. */
const begins = parts(/`(\w+\.\w+)\$\{[^`]*`/g);
const ends = parts(/`\w+\.\$\{[^`]*\}(\w+)`/g);

const tables: [string, Tables][] = [
  ["shared", { en, ko, ja }],
  ...Object.entries(panels).flatMap(([file, found]) =>
    Object.values(found).map(({ en, ko, ja }): [string, Tables] => [file, { en, ko, ja }]),
  ),
];
const all = tables.flatMap(([file, table]) => Object.keys(table.en).map((word) => [file, word, table] as const));

const SENTENCE = /[.?。？]$/;
/** The verbs that buttons begin with. */
const VERBS = new Set(
  (
    "Accept Add Align Apply Approve Archive Build Cancel Change Choose Clear Close Collect Comment Compare Compose Confirm Copy Create " +
    "Delete Discard Do Download Duplicate Edit Exclude Export Extend Extract Find Fit Go Hide Hold Import Invite Keep Label Make Measure Merge Mirror " +
    "Move New Open Pause Play Pose Preview Propose Rebase Rebuild Record Redo Refine Reload Remove Reopen Repair Replace Resend Reset Resolve Restore " +
    "Retarget Retry Revoke Run Save Search Select Send Set Share Show Sign Split Start Stop Suggest Take Tap Toggle Trim " +
    "Try Undo Use Validate Zoom"
  ).split(" "),
);

describe("the words of all languages", () => {
  it.each(all)("%s %s: the same values stand in all sentences, one or two forms", (_, word, tables) => {
    for (const table of languages.map((known) => tables[known])) {
      expect(holes(entryOf(table, word))).toEqual(holes(entryOf(tables.en, word)));
      const forms = entryOf(table, word).split("|");
      expect(forms.length).toBeLessThanOrEqual(2);
      expect(forms.every((form) => form.trim() === form && form !== "")).toBe(true);
      // What is one is said without its number, or with it; what is many shows every value.
      if (forms.length === 2) expect(holes(itemAt(forms, 1))).toEqual(holes(entryOf(table, word)));
    }
  });

  it("keep the rules of their kind, which their key begins with", () => {
    const wrong = all.flatMap(([file, word, tables]) => {
      const kind = word.split(".")[0];
      const forms = languages.flatMap((known) => entryOf(tables[known], word).split("|"));
      const sentences = forms.filter((form) => SENTENCE.test(form)).length;
      const keeps =
        kind === "help" || kind === "error"
          ? sentences === forms.length
          : (kind === "label" || kind === "button") && sentences === 0;
      const isCommand = VERBS.has(entryOf(tables.en, word).split(/[ |]/)[0] ?? "");
      return keeps && (kind !== "button" || isCommand) ? [] : [`${file} ${word}`];
    });
    expect(wrong).toEqual([]);
  });

  it("are used", () => {
    const unused = all.filter(
      ([, word]) =>
        !quoted.has(word) &&
        !quoted.has(word.replace("label.", "")) &&
        !begins.some((begin) => word.startsWith(begin)) &&
        !ends.some((end) => word.endsWith(end)),
    );
    expect(unused.map(([file, word]) => `${file} ${word}`)).toEqual([]);
  });

  it("have the same keys", () => {
    for (const [, table] of tables)
      for (const known of languages) expect(Object.keys(table[known]).sort()).toEqual(Object.keys(table.en).sort());
  });

  it("are filled with numbers as each language writes them", () => {
    language.value = "en";
    expect(w("label.clips", { n: 1 })).toBe("1 clip");
    expect(w("label.clips", { n: 12345 })).toBe("12,345 clips");
    expect(w("label.clips", { n: 0 })).toBe("0 clips");
    expect(w("label.deleted", { n: 2 })).toContain("2");
  });
});

describe("durations and rates", () => {
  it("are now within the first minute, then of minutes", () => {
    const ago = (seconds: number) => when(new Date(Date.now() - 1000 * seconds).toISOString());
    expect(ago(5)).toBe("now");
    expect(ago(125)).toBe("2 min. ago");
  });

  it("are short, and a minute has sixty seconds", () => {
    language.value = "en";
    expect(duration(null)).toBe("–");
    expect(duration(4.2)).toBe("4.2 s");
    expect(duration(12.34)).toBe("12.3 s");
    expect(duration(124.5)).toBe("2:04.5");
    expect(duration(119.97)).toBe("2:00.0");
    expect(duration(59.98)).toBe("1:00.0");
    expect(rate(0.0083333)).toBe("120 Hz");
  });
});
