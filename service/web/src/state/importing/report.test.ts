// @vitest-environment happy-dom
import { describe, expect, it } from "vitest";
import { countOutcomes, linesOf, reportAsCsv, reportOf, storedIn } from "./report";
import type { Upload } from "./uploads";

type Imported = Upload["documents"][number];
const clip = (file: string, more: Partial<Imported["receipt"]> & { skipped?: boolean } = {}): Imported => {
  const { skipped = false, ...receipt } = more;
  return { id: `id of ${file}`, name: file, file, skipped, receipt: { notices: [], twins: [], ...receipt } } as never;
};
const upload = (more: Partial<Upload>): Upload => ({
  id: 1,
  files: [],
  name: "all.zip",
  state: "stored",
  sent: 1,
  documents: [],
  problems: [],
  ...more,
});
const warning = { kind: "warning", what: "the header states no frame rate", at: "line 3" } as const;
const note = { kind: "note", what: "the take has a single frame" } as const;
const bad = {
  file: "all.zip/b.bvh",
  problem: { title: "=cmd", detail: 'Line 4, "x"', remedy: "Mend it.", where: { line: 4 } },
} as never;
const zip = upload({
  documents: [
    clip("all.zip/sub/a.bvh"),
    clip("c.bvh", { notices: [note] }),
    clip("d.htr", { notices: [warning, note] }),
    clip("e.bvh", { twins: ["other"], notices: [warning] }),
    clip("f.bvh", { skipped: true }),
  ],
  problems: [bad],
});

describe("the report of an import", () => {
  it("has a line for each clip and each problem, by the name of the file", () => {
    expect(linesOf(zip).map(({ folder, file, outcome }) => [folder, file, outcome])).toEqual([
      ["all.zip/", "b.bvh", "refused"],
      ["all.zip/sub/", "a.bvh", "stored"],
      ["", "c.bvh", "stored"],
      ["", "d.htr", "warned"],
      ["", "e.bvh", "existing"],
      ["", "f.bvh", "existing"],
    ]);
    expect(new Set(linesOf(zip).map((one) => one.key)).size).toBe(6);
  });

  it("counts every line once, and names the clips that were stored", () => {
    const lines = reportOf([zip, upload({ id: 2, name: "x.bvh", state: "cancelled" })]);
    expect([...countOutcomes(lines).values()].reduce((sum, one) => sum + one, 0)).toBe(lines.length);
    expect(storedIn(lines)).not.toContain("id of f.bvh");
    expect(storedIn(lines)).toHaveLength(4);
  });

  it("shows problems first once all files are done, and the newest first before", () => {
    expect(reportOf([zip]).map((one) => one.outcome)).toEqual([
      "refused",
      "warned",
      "existing",
      "existing",
      "stored",
      "stored",
    ]);
    const running = upload({ id: 2, name: "next.bvh", state: "reading" });
    expect(reportOf([zip, running])[0]).toMatchObject({ file: "next.bvh", outcome: "underway" });
    // What is tried again is under way, whatever became of it before.
    expect(linesOf(upload({ state: "queued", problems: [bad] })).map((one) => one.outcome)).toEqual(["underway"]);
  });

  it("becomes CSV that spreadsheets read and do not run", () => {
    const text = reportAsCsv(
      reportOf([zip]),
      (outcome) => outcome,
      (id) => `/clips/${id}`,
    );
    const rows = text.split("\r\n");
    expect(rows).toHaveLength(8);
    expect(rows[0]).toBe("file,outcome,clip,address,line,message,remedy");
    expect(rows[1]).toBe(`all.zip/b.bvh,refused,,,4,"'=cmd Line 4, ""x""",Mend it.`);
    expect(rows[2]).toBe('d.htr,warned,d.htr,/clips/id of d.htr,,"the header states no frame rate, line 3",');
  });
});
