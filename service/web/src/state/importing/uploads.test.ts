// @vitest-environment happy-dom
import { beforeAll, describe, expect, it } from "vitest";
import { learnFormats } from "../../testing/formats";
import { filesOf } from "./dropped";
import { filesDone, grouped, outcomes, rowsOf, together, type Upload } from "./uploads";

beforeAll(learnFormats);

const file = (path: string): File => Object.assign(new File([""], path.split("/").at(-1)!), { path: `/${path}` });
const names = (groups: File[][]) =>
  groups.map((group) => group.map((one) => (one as File & { path: string }).path.slice(1)).sort()).sort();

describe("files that are stored together", () => {
  it("are an ASF and the AMCs of its folder", () => {
    const files = ["a/02.asf", "b/05.asf", "a/02_01.amc", "a/02_02.AMC", "b/05_01.amc", "a/walk.bvh"].map(file);
    expect(names(grouped(files))).toEqual([
      ["a/02.asf", "a/02_01.amc", "a/02_02.AMC"],
      ["a/walk.bvh"],
      ["b/05.asf", "b/05_01.amc"],
    ]);
  });

  it("are none where there is no ASF: each AMC by itself is refused by itself", () => {
    expect(names(grouped(["a/1.amc", "a/2.amc", "b/3.asf"].map(file)))).toEqual([
      ["a/1.amc"],
      ["a/2.amc"],
      ["b/3.asf"],
    ]);
  });

  it("are those of a format and the files beside them, in any folder", () => {
    const files = ["markers/walk.trc", "forces/walk_grf.mot", "run.trc", "walk.bvh"].map(file);
    expect(names(grouped(files))).toEqual([["forces/walk_grf.mot", "markers/walk.trc", "run.trc"], ["walk.bvh"]]);
    expect(names(grouped(["a/walk.trc", "b/run.trc"].map(file)))).toEqual([["a/walk.trc"], ["b/run.trc"]]);
  });

  it("are told by folder also where a dialogue chose them", () => {
    const chosen = (path: string) =>
      Object.defineProperty(new File([""], path.split("/").at(-1)!), "webkitRelativePath", { value: path });
    expect(
      grouped(["x/1.asf", "y/1.amc", "x/1.amc"].map(chosen))
        .map((group) => group.length)
        .sort(),
    ).toEqual([1, 2]);
    expect(grouped([new File([""], "1.asf"), new File([""], "1.amc")]).length).toBe(1);
  });

  it("are every file once", () => {
    const files = ["a/1.amc", "2.bvh", "3.zip", "a/4.asf", "b/5.amc", "b/6.htr"].map(file);
    expect(grouped(files).flat().length).toBe(files.length);
    expect(new Set(grouped(files).flat())).toEqual(new Set(files));
    expect(grouped([])).toEqual([]);
  });
});

const upload = (name: string, bytes = 10, more = 0): Upload => ({
  id: 0,
  name,
  files: Array.from({ length: 1 + more }, () => ({ name, size: bytes }) as File),
  state: "queued",
  sent: 0,
  documents: [],
  problems: [],
});
const chosen = (queue: Upload[]) => together(queue).map((one) => one.name);
const MIB = 1 << 20;

describe("uploads that share a request", () => {
  it("are short single files, as many as are worth it", () => {
    const queue = Array.from({ length: 40 }, (_, n) => upload(`${n}.bvh`));
    expect(together(queue)).toEqual(queue.slice(0, 32));
    expect(together([])).toEqual([]);
    expect(chosen([upload("a.bvh", 5 * MIB), upload("b.c3d", 3 * MIB), upload("c.htr", 1)])).toEqual([
      "a.bvh",
      "b.c3d",
    ]);
    expect(chosen([upload("long.bvh", 500 * MIB), upload("b.bvh")])).toEqual(["long.bvh"]);
  });

  it("are none that hold several files, nor two of one name", () => {
    expect(chosen([upload("a.bvh"), upload("x.zip"), upload("b.bvh")])).toEqual(["a.bvh"]);
    expect(chosen([upload("x.zip"), upload("b.bvh")])).toEqual(["x.zip"]);
    expect(chosen([upload("1.asf", 10, 3), upload("b.bvh")])).toEqual(["1.asf"]);
    for (const name of ["notes.txt", "x.tar", "a.bvh.gz", "b.fbx", "noending"])
      expect(chosen([upload("a.bvh"), upload(name)])).toEqual(["a.bvh"]);
    expect(chosen([upload("a.bvh"), upload("a.bvh")])).toEqual(["a.bvh"]);
  });

  it("are told what became of each", () => {
    const [a, b, c] = ["a.bvh", "b.bvh", "c.bvh"].map((name) => upload(name)) as [Upload, Upload, Upload];
    const made = (name: string) => ({ id: name, name, skipped: false }) as Upload["documents"][number];
    const bad = { file: "b.bvh", problem: { title: "Format error" } };
    expect(outcomes([a, b, c], [made("a"), made("c")], [bad])).toEqual([
      { state: "stored", documents: [made("a")], problems: [] },
      { state: "refused", documents: [], problems: [bad] },
      { state: "stored", documents: [made("c")], problems: [] },
    ]);
    const zip = upload("all.zip");
    expect(outcomes([zip], [made("a"), made("c")], [bad])).toEqual([
      { state: "stored", documents: [made("a"), made("c")], problems: [bad] },
    ]);
  });

  it("are told by their names where files and clips do not match one to one", () => {
    const [a, b, c] = ["a.bvh", "b.bvh", "c.bvh"].map((name) => upload(name)) as [Upload, Upload, Upload];
    const made = (name: string) => ({ id: name, name, skipped: false }) as Upload["documents"][number];
    const [first, second, third] = outcomes([a, b, c], [made("a"), made("c")], []);
    expect([first!.state, second!.state, third!.state]).toEqual(["stored", "refused", "stored"]);
    expect(second!.problems).toHaveLength(1);
    expect(third!.documents).toEqual([made("c")]);
  });
});

describe("every file that is dropped", () => {
  const all = ["walk.bvh", "model.fbx", "notes.txt", ".DS_Store", "noending", "walk.bvh"].map(file);

  it("has a row, of unknown kinds too", () => {
    expect(rowsOf(all).map((one) => [one.name, one.state])).toEqual(all.map((one) => [one.name, "queued"]));
  });

  it("is counted, with what could not be read", () => {
    const rows = rowsOf(all, [{ file: "empty/", problem: { title: "Empty folder" } }]);
    expect(rows.at(-1)).toMatchObject({ name: "empty/", state: "refused", problems: [{ file: "empty/" }] });
    expect(filesDone(rows)).toEqual({ done: 1, of: all.length + 1 });
  });

  it("beyond the most is told of in a row of its own", () => {
    const rows = rowsOf(Array.from({ length: 5003 }, (_, n) => file(`${n}.bvh`)));
    expect(rows).toHaveLength(5001);
    expect(rows.at(-1)!.name).toContain("3");
    expect(rows.at(-1)!.problems).toHaveLength(1);
  });

  const entry = (path: string, held: unknown[] | Error | File) => ({
    fullPath: path,
    isFile: !Array.isArray(held),
    file: (good: (file: File) => void, bad: (error: Error) => void) =>
      held instanceof Error ? bad(held) : good(held as File),
    createReader: () => {
      let some = held as unknown[];
      return {
        readEntries: (good: (entries: unknown[]) => void) => {
          good(some);
          some = [];
        },
      };
    },
  });
  const dropped = (items: { entry?: unknown; file?: File }[]) =>
    filesOf({
      files: [] as never,
      items: items.map(({ entry, file }) => ({
        kind: "file",
        webkitGetAsEntry: () => entry ?? null,
        getAsFile: () => file ?? null,
      })) as never,
    });

  it("is found in folders; what cannot be read stops no other", async () => {
    const good = new File(["x"], "a.bvh");
    const found = await dropped([
      {
        entry: entry("/one", [
          entry("/one/a.bvh", good),
          entry("/one/locked.bvh", new Error("no permission")),
          entry("/one/empty", []),
        ]),
      },
      { file: new File(["y"], "b.bvh") },
      {},
    ]);
    expect(found.files.map((one) => one.name)).toEqual(["a.bvh", "b.bvh"]);
    expect(found.missed.map((one) => one.file).slice(0, 2)).toEqual(["one/locked.bvh", "one/empty/"]);
    expect(found.missed[0]!.problem.detail).toBe("no permission");
    expect(found.missed).toHaveLength(3);
  });
});
