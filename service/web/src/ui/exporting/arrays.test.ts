import { expect, test } from "vitest";
import { arraysByCommand, arraysByCurl, arraysByPython, type ArraysRequest } from "./arrays";

const picked: ArraysRequest = { selection: { documents: ["a", "b"] }, space: "positions", columns: "all", as: "npz" };
const asked: ArraysRequest = {
  selection: { project: "it's" },
  query: "//frame[motion_name='walk']",
  space: "rotations",
  columns: "shared",
  as: "parquet",
};

test("lines for a shell hold quotes of the query", () => {
  expect(arraysByCommand(picked, "http://here")).toBe(
    "mcml arrays arrays.npz a b --space positions --server http://here",
  );
  expect(arraysByCommand(asked, "http://here")).toBe(
    String.raw`mcml arrays arrays.parquet --project 'it'\''s' --query '//frame[motion_name='\''walk'\'']' --space rotations --columns shared --server http://here`,
  );
  const line = arraysByCurl(asked, "http://here", true);
  expect(line).toContain('-H "Authorization: Bearer $MCML_TOKEN"');
  const body = line.slice(line.indexOf(" -d '") + 5, -1).replaceAll(String.raw`'\''`, "'");
  expect(JSON.parse(body)).toEqual(asked);
});

test("Python gets the same clips", () => {
  expect(arraysByPython(picked, "http://here", false)).toContain('repo.arrays(documents=["a","b"], space="positions")');
  const script = arraysByPython(asked, "http://here", true);
  expect(script).toContain('token=os.environ["MCML_TOKEN"]');
  expect(script).toContain(
    `repo.arrays(project="it's", query="//frame[motion_name='walk']", space="rotations", columns="shared")`,
  );
});
