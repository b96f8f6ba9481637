"""What helps while an expression is typed: completions, and hints about names that reach nothing."""

from __future__ import annotations

from contextlib import suppress

from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import LimitError, QueryError
from mcml_service.xpath.language.complete import complete
from mcml_service.xpath.language.hints import unknown_names
from mcml_service.xpath.language.parse import parse


def items(text: str, at: int | None = None) -> tuple[int, list[str]]:
    first, found = complete(
        text,
        len(text) if at is None else at,
        lambda: {"walk": 2, "left-arm-abduction": 1},
        lambda: {"Hips": 3, "left_up_arm": 3},
    )
    return first, [item.text for item in found]


def test_elements_follow_the_content_models() -> None:
    assert items("/mcml/m") == (6, ["motion"])
    assert items("//fr")[1][:2] == ["frame", "frame_bone"]
    assert items("//frame/")[1][:2] == ["frame_bone", "motion_name"]
    assert items("(//frame)[1]/mot")[1][0] == "motion_name"
    assert items("//bone[na")[1] == ["name", "name(", "namespace-uri(", "namespace::", "local-name(", "mo:analog("]


def test_attributes_are_those_of_the_element() -> None:
    assert items("//frame/@") == (9, ["id"])
    assert items("//frame_bone[@Rx > 45]/@R")[1] == ["Rx", "Ry", "Rz", "residual"]
    assert items("//frame[frame_bone/@T")[1] == ["Tx", "Ty", "Tz"]


def test_names_that_occur_are_offered_where_they_are_compared() -> None:
    assert items("//frame[motion_name='w") == (21, ["walk"])
    assert items('//frame_bone[@name = "l')[1] == ["left_up_arm"]
    assert items("//bone[name='")[1] == ["Hips", "left_up_arm"]
    assert items("//frame[@id='") == (13, [])


def test_functions_of_bodies_in_motion() -> None:
    assert items("//frame[mo:hei") == (8, ["mo:height("])
    assert items("//frame[hei") == (8, ["mo:height("])
    assert items("//frame[1 < mo:")[1][:3] == ["mo:time(", "mo:unit(", "mo:leg("]
    assert items("//frame/mo:sp") == (8, ["mo:speed("])
    assert items("//frame[min(mo:window(-1, 0)/spe")[1] == ["mo:speed("]
    assert items("mo:top(3, //frame, mo:window(0, 1)/mot")[1][:1] == ["motion_name"]
    assert "mo:speed(" not in items("/mcml/header/sp")[1]
    _, found = complete("//frame[mo:speed", 16, dict, dict)
    assert [item.detail for item in found] == [
        "(joint, relative?) in m/s: of a joint, by itself or relative to another one"
    ]


def test_what_their_arguments_name() -> None:
    assert items("//frame[mo:height('") == (19, ["Hips", "left_up_arm"])
    assert items('//frame[mo:distance("Hips", "l')[1] == ["left_up_arm"]
    assert items("//frame[mo:angle('left-kn")[1][:2] == ["left-knee-flexion", "left-knee-extension"]
    assert items("//frame[mo:angle('Hips', 'left")[1] == ["left_up_arm"]
    assert items("//frame[mo:angle('l', 'Hips', 'Hips')]", 19)[1] == ["left_up_arm"]
    assert items("//frame[mo:position('Hips', 'f")[1] == ["front"]
    assert items("//frame[mo:position('Hips', '")[1] == ["x", "y", "z", "up", "front", "left"]
    assert items("//frame[mo:window(-1, 0, '")[1] == ["frames"]
    assert items("//frame[mo:window('")[1] == []
    assert items("//frame[mo:height(frame_bone[@name='l")[1] == ["left_up_arm"]
    assert items("//frame[contains('")[1] == []
    _, found = complete("//frame[mo:angle('left-knee-f", 28, dict, lambda: {"left_up_arm": 3})
    assert {item.kind for item in found} == {"angle"}
    _, found = complete("//frame[mo:angle('left-leg-f", 28, dict, dict)
    details = {item.text: item.detail for item in found}
    assert details["left-leg-flexion"] == "goniometer; clinical: left-hip-flexion"


def test_a_cursor_in_the_middle() -> None:
    assert items("//fra[motion_name='walk']", 5)[1][:4] == ["frame", "frame_bone", "frames", "frametime"]
    assert "ancestor::" in items("//frame/anc")[1]
    assert "count(" in items("//frame[cou")[1]


@given(st.text(alphabet="/@[]()|*.:='\"$-+<>!,ab1 framotion_", max_size=40), st.integers(0, 40))
def test_whatever_is_typed_is_completed(text: str, at: int) -> None:
    first, found = items(text, min(at, len(text)))
    assert 0 <= first <= len(text)
    assert len(found) == len(set(found)) or not found
    with suppress(QueryError, LimitError):
        unknown_names(parse(text).tree)


def test_names_that_reach_nothing_get_the_nearest() -> None:
    def hint(text: str) -> str:
        (found,) = unknown_names(parse(text).tree)
        return found

    assert hint("//fram") == "MCML has no element fram; did you mean frame?"
    assert hint("//frame_bone/@rx") == "MCML has no attribute @rx; did you mean @Rx?"
    assert hint("//frame/@Rx") == "frame has no attribute @Rx; it is one of frame_bone"
    assert hint("/mcml/frame") == "mcml holds no frame; it is in motion"
    assert hint("count(//frame[motionname='walk'])") == "MCML has no element motionname; did you mean motion_name?"
    assert hint("//@motion_name") == "motion_name is an element: leave the @ out"
    assert hint("//frame[Rx > 5]") == "Rx is an attribute: write @Rx"
    assert unknown_names(parse("//frame[motion_name='walk']/frame_bone/@Rx").tree) == []
    assert unknown_names(parse("//frame/text()").tree) == []
