// @vitest-environment happy-dom
import { expect, it } from "vitest";
import { language } from "../../state/session/settings";
import { problemTitle } from "./titles";

it("titles of known kinds are in the language of the studio, others are those of the server", () => {
  const known = { type: "/docs/problems#not-found-error", title: "Not found error" };
  expect(problemTitle(known)).toBe("Not found error");
  language.value = "ko";
  expect(problemTitle(known)).toBe("찾을 수 없음");
  expect(problemTitle({ type: "about:blank", title: "Method Not Allowed" })).toBe("Method Not Allowed");
  expect(problemTitle({ type: "/docs/problems#of-tomorrow" })).toBe("");
  language.value = "en";
});
