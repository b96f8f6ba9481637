import { describe, expect, it } from "vitest";
import { Pace, timeLeft } from "./pace";

describe("the pace of an import", () => {
  const timed = () => {
    const time = { now: 1000 };
    return { time, pace: new Pace(() => time.now) };
  };

  it("is told once it is known: files a second, and what is left", () => {
    const { time, pace } = timed();
    expect(pace.now(100)).toBeNull();
    pace.tell(0);
    time.now += 400;
    pace.tell(4);
    expect(pace.now(100)).toBeNull();
    time.now += 600;
    pace.tell(10);
    expect(pace.now(100)).toEqual({ rate: 10, left: 9 });
    pace.tell(100);
    expect(pace.now(100)).toBeNull();
  });

  it("is that of the last seconds, and falls while a long file is read", () => {
    const { time, pace } = timed();
    pace.tell(0);
    // A thousand that are here already, then one a second.
    time.now += 1000;
    pace.tell(1000);
    for (let done = 1001; done <= 1030; done++) {
      time.now += 1000;
      pace.tell(done);
    }
    expect(pace.now(1050)).toEqual({ rate: 1, left: 20 });
    time.now += 15_000;
    expect(pace.now(1050)!.rate).toBeCloseTo(0.5);
  });

  it("says a time as one reads it", () => {
    expect([0.2, 9.4, 59.4, 59.6, 124, 3724].map(timeLeft)).toEqual(["1 s", "9 s", "59 s", "1:00", "2:04", "1:02:04"]);
  });
});
