// @vitest-environment happy-dom
import { afterEach, describe, expect, it } from "vitest";
import { language } from "../../state/session/settings";
import { angleText, jointText } from "./bodyNames";

afterEach(() => (language.value = "en"));

describe("names of angles", () => {
  it("have a side, a part of the body and a movement, in each language", () => {
    expect(angleText("left-knee-flexion")).toBe("left knee flexion");
    expect(angleText("trunk-right-lateral-flexion")).toBe("trunk right lateral flexion");
    language.value = "ja";
    expect(angleText("left-knee-flexion")).toBe("左膝の屈曲");
    expect(angleText("pelvis-tilt")).toBe("骨盤の前後傾");
    language.value = "ko";
    expect(angleText("right-hip-internal-rotation")).toBe("오른쪽 엉덩관절 안쪽 돌림");
  });

  it("stay as they are where there is no word", () => {
    language.value = "ja";
    expect(angleText("left-finger-two-flexion")).toBe("left finger two flexion");
    expect(angleText("sideways")).toBe("sideways");
    expect(jointText("left_hand")).toBe("左手");
  });
});
