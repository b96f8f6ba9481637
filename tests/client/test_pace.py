"""How fast an import is told to be, by a clock that the test turns."""

from __future__ import annotations

from mcml.client.pace import FEWEST_SECONDS, LOOKED_BACK, Pace


class _Clock:
    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


def test_rate_and_time_left_are_told_once_they_are_known() -> None:
    clock = _Clock()
    pace = Pace(clock=clock)
    assert (pace.rate, pace.left, str(pace)) == (None, None, "")
    pace.tell(0, 3000)
    clock.now += FEWEST_SECONDS / 2
    pace.tell(100, 3000)
    assert pace.rate is None
    clock.now += 10 - FEWEST_SECONDS / 2
    pace.tell(2000, 3000)
    assert (pace.rate, pace.left, str(pace)) == (200.0, 5.0, "200 files/s, 0:05 left")


def test_what_went_by_long_ago_does_not_count() -> None:
    clock = _Clock()
    pace = Pace(clock=clock)
    # Files that were stored already.
    pace.tell(0, 10_000)
    clock.now += 1
    pace.tell(5000, 10_000)
    for _ in range(round(LOOKED_BACK) + 1):
        clock.now += 1
        pace.tell(pace._told[-1][1] + 2, 10_000)
    assert pace.rate == 2.0
    assert str(pace) == "2.0 files/s, 41:24 left"


def test_the_rate_sinks_while_a_long_file_is_read() -> None:
    clock = _Clock()
    pace = Pace(clock=clock)
    pace.tell(0, 4)
    clock.now += 4
    pace.tell(2, 4)
    assert pace.rate == 0.5
    clock.now += 4
    assert pace.rate == 0.25
    clock.now += 592
    pace.tell(3, 4)
    assert str(pace) == "0.1 a minute, 9:56 left"


def test_nothing_done_is_no_rate() -> None:
    clock = _Clock()
    pace = Pace(clock=clock)
    pace.tell(0, 4)
    clock.now += 60
    pace.tell(0, 4)
    assert (pace.rate, str(pace)) == (None, "")
