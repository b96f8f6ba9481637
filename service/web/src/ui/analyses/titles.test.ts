// @vitest-environment happy-dom
import { afterEach, describe, expect, it } from "vitest";
import { language } from "../../state/session/settings";
import { analysisHelp, analysisTitle } from "./titles";

afterEach(() => (language.value = "en"));

describe("titles of analyses", () => {
  it("are in the language of the studio", () => {
    const gait = { name: "gait", title: "Gait parameters", description: "Of trials." };
    expect(analysisTitle(gait)).toBe("Gait parameters");
    language.value = "ko";
    expect(analysisTitle(gait)).toBe("보행 지표");
    expect(analysisHelp(gait)).toContain("보행");
  });

  it("are those of the package for analyses of others", () => {
    const own = { name: "jumps", title: "Jumps", description: "How high." };
    expect(analysisTitle(own)).toBe("Jumps");
    expect(analysisHelp(own)).toBe("How high.");
  });
});
