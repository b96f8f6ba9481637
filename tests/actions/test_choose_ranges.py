"""Ranges of labels, and values by which ranges are grouped."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from mcml.motion.bodies.quantities import asked_quantity
from mcml_service.actions.measuring.choose_ranges import Range, ranges_of_labels
from mcml_service.actions.measuring.measure_clips import ClipFacts, value_of
from mcml_service.storage.documents.spans import StoredSpan


@given(st.lists(st.tuples(st.integers(1, 30), st.integers(0, 5), st.sampled_from("ab")), max_size=8))
def test_cycles_of_labels(drawn: list[tuple[int, int, str]]) -> None:
    spans = sorted(StoredSpan(first, first + length, 0, name) for first, length, name in drawn)
    found = list(ranges_of_labels(spans, ["a"]))
    own = [(span.first, span.last) for span in spans if span.name == "a"]
    if all(first == last for first, last in own):
        assert len(found) == max(0, len(set(own)) - 1)
        assert all(one.last == other.first for one, other in pairwise(found))
    else:
        assert [(each.first, each.last) for each in found] == own
    assert all(each.begin <= each.end and each.label == "a" for each in found)


def test_people_are_told_apart_by_the_prefix_of_their_markers() -> None:
    asked = asked_quantity("distance:Anna:LHEE,Anna:RHEE")
    facts = ClipFacts("id", "name", "project", 1, 0.01, {})
    each = Range.of_frames(1, 2)
    assert value_of("person", asked, facts, each) == "Anna"
    assert value_of("side", asked, facts, each) == ""
    assert value_of("property:age", asked, facts, each) == ""
