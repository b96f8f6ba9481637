// @vitest-environment happy-dom
import { afterEach, describe, expect, it } from "vitest";
import { language } from "../../state/session/settings";
import { quantityName } from "./names";

afterEach(() => (language.value = "en"));

describe("names of quantities", () => {
  it("have joints, movements and axes as people say them", () => {
    expect(quantityName("speed:left_hand")).toBe("Speed: left hand");
    expect(quantityName("angle:left-knee-flexion")).toBe("Left knee flexion");
    expect(quantityName("position:right_foot,up")).toBe("Position: right ankle, up");
    expect(quantityName("contact:left")).toBe("Foot contact: left");
    expect(quantityName("heading")).toBe("Heading");
    language.value = "ja";
    expect(quantityName("speed:left_hand")).toBe("左手の速度");
    language.value = "ko";
    expect(quantityName("speed:left_hand")).toBe("왼쪽 손 속력");
  });

  it("stay as they are where they are of a file", () => {
    expect(quantityName("quantity:LKneeAngles,x")).toBe("LKneeAngles, x");
    expect(quantityName("analog:EMG1")).toBe("Analog channel: EMG1");
    expect(quantityName("angle:Root,left_up_leg,left_low_leg")).toBe("Angle: Root, left_up_leg, left_low_leg");
  });
});
