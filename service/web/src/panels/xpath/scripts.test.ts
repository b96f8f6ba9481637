import { describe, expect, it } from "vitest";
import { quoted } from "../../ui/exporting/arrays";
import { asCommand, asCurl, asPython } from "./scripts";

describe("lines for scripts", () => {
  it("hold any question, in any scope", () => {
    const asked = { q: `//frame[motion_name='it"s $1']`, project: "my clips", form: "runs" as const };
    expect(quoted("a'b")).toBe(`'a'\\''b'`);
    expect(asCurl(asked, "http://x")).toBe(
      `curl -G http://x/api/v1/xpath --data-urlencode 'q=//frame[motion_name='\\''it"s $1'\\'']' --data-urlencode 'project=my clips' -d as=runs`,
    );
    expect(asCommand({ ...asked, q: "//frame", project: "" }, "http://x")).toBe(
      "mcml xpath '//frame' --server http://x --as runs",
    );
    expect(asPython(asked, "http://x")).toContain(`repo.xpath("//frame[motion_name='it\\"s $1']", project="my clips")`);
    expect(asPython({ ...asked, form: "json" }, "http://x")).toContain("found.nodes()");
  });

  it("carry the token of a server that asks for one", () => {
    expect(asCurl({ q: "//frame", project: "", form: "runs", token: true }, "http://x")).toContain(
      '/xpath -H "Authorization: Bearer $MCML_TOKEN" ',
    );
    expect(asPython({ q: "//frame", project: "", form: "runs", token: true }, "http://x")).toContain(
      'import os\n\nimport mcml\n\nrepo = mcml.open("http://x", token=os.environ["MCML_TOKEN"])',
    );
  });

  it("leave out guesses where the page does", () => {
    const asked = { q: "//frame", project: "", form: "runs" as const, guesses: false };
    expect(asCurl(asked, "http://x")).toContain(" -d guesses=no ");
    expect(asCommand(asked, "http://x")).toContain(" --guesses no ");
    expect(asPython(asked, "http://x")).toContain('repo.xpath("//frame", guesses="no")');
  });

  it("say that each document is asked by itself, and print values", () => {
    const asked = { q: "count(//frame)", project: "", form: "json" as const, per: true, values: true };
    expect(asCurl(asked, "http://x")).toBe(
      "curl -G http://x/api/v1/xpath --data-urlencode 'q=count(//frame)' -d per=document -d as=json",
    );
    expect(asCommand(asked, "http://x")).toBe("mcml xpath 'count(//frame)' --server http://x --per document --as json");
    expect(asPython(asked, "http://x")).toContain(
      'found = repo.xpath("count(//frame)", per="document")\nprint(found.value())\n',
    );
  });
});
