import { describe, expect, it } from "vitest";
import { fadedRange, handleOf, handlesOf, poseEdit, STILL, type HandleName, type Moved } from "./handles";

const UP: Moved = { move: [0, 10, 0], turn: [0, 0, 0] };
const choices = (moves: [HandleName, Moved][], range: [number, number] = [50, 50]) => ({
  moves: new Map(moves),
  range,
  fade: 9,
  keepFeet: true,
});

describe("a pose", () => {
  it("is an edit of the frames over which it fades in and out", () => {
    expect(poseEdit(choices([["left_hand", UP]]), 100)).toEqual([
      {
        do: "pose",
        first: 41,
        last: 59,
        ease: 9,
        hold: ["left_foot", "right_foot"],
        handles: [{ handle: "left_hand", ...UP }],
      },
    ]);
  });

  it("is none where nothing is moved", () => {
    expect(poseEdit(choices([]), 100)).toBeNull();
    expect(poseEdit(choices([["head", STILL]]), 100)).toBeNull();
  });

  it("leaves out parts that were moved back", () => {
    const [edit] =
      poseEdit(
        choices([
          ["head", STILL],
          ["hips", UP],
        ]),
        100,
      ) ?? [];
    expect(edit).toMatchObject({ handles: [{ handle: "hips" }] });
  });

  it("ends where the clip ends", () => {
    expect(fadedRange([3, 98], 9, 100)).toEqual([1, 100]);
  });

  it("moves limbs that are there in whole", () => {
    const joints = ["Root", "Head", "left_up_arm", "left_low_arm", "left_hand", "right_up_leg", "right_foot"];
    const byName = new Map(joints.map((name, index) => [name, index]));
    expect(handlesOf({ byName })).toEqual(["hips", "head", "left_hand"]);
    expect(handlesOf({ byName: new Map([["Head", 0]]) })).toEqual([]);
  });

  it("moves joints by their names", () => {
    expect(handleOf("Root")).toBe("hips");
    expect(handleOf("left_low_arm")).toBeNull();
    expect(handleOf(undefined)).toBeNull();
  });
});
