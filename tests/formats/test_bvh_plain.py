"""The quick reader of plain hierarchies against the one that knows all of the grammar."""

from __future__ import annotations

import io
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import McmlError, Notice
from mcml.formats.bvh.hierarchy import SharedHierarchy, read_hierarchy, shared_hierarchy
from mcml.formats.bvh.plain import read_plain
from mcml.formats.format import Limits
from mcml.formats.text.lines import Encoding, Lines, Tokens

LIMITS = Limits(joints=12, depth=5, name=20)
WORDS = ("ROOT", "JOINT", "End Site", "OFFSET", "CHANNELS", "{", "}", "0", "1.5", "3", "Xposition", "Zrotation", "a b")
ENDS = ("\n", "\r\n", "\r", "\n\n", " \n\t")


def hierarchy(chance: random.Random) -> str:
    """What a program may write: joints in joints, end sites, channels in any order, several roots."""
    end = chance.choice(ENDS)
    lines = ["HIERARCHY"]

    def offset() -> str:
        numbers = ["1e-3"] if chance.random() < 0.02 else ["0", "-1.5", ".25", "2.", "+3", "007"]
        return "OFFSET " + " ".join(chance.choice(numbers) for _ in range(3))

    def joint(keyword: str, depth: int) -> None:
        names = ["Left Arm"] if chance.random() < 0.03 else ["Hips", "b:Arm-1", "Ärmel", "x"]
        lines.append(f"{keyword} {chance.choice(names)}{chance.choice('12')}")
        lines.extend(["{", offset()])
        if chance.random() < 0.9:
            channels = [f"{axis}{kind}" for kind in ("position", "rotation") for axis in "XYZ"]
            chosen = chance.sample(channels, chance.randint(1, 6))
            lines.append(f"CHANNELS {len(chosen)} {' '.join(chosen)}")
        for _ in range(chance.choice([0, 1, 1, 2])):
            if depth < 5 and chance.random() < 0.7:
                joint("JOINT", depth + 1)
            else:
                lines.extend(["End Site", "{", offset(), "}"])
        lines.append("}")

    for _ in range(chance.choice([1, 1, 1, 1, 2])):
        joint("ROOT", 0)
    return end.join([*lines, ""])


def damaged(text: str, chance: random.Random) -> str:
    """One word, character or line more, less, or twice."""
    place = chance.randrange(len(text) + 1)
    kind = chance.randrange(4)
    if kind == 0:
        return text[:place] + text[place + chance.randint(1, 8) :]
    if kind == 1:
        return text[:place] + chance.choice([*WORDS, *ENDS, "\0", "\x01", "\u00a0"]) + text[place:]
    if kind == 2:
        return text[:place] + text[max(0, place - 30) :]
    return text.swapcase() if chance.random() < 0.2 else text.replace(chance.choice(WORDS), chance.choice(WORDS), 1)


def by_the_grammar(text: bytes, limits: Limits) -> SharedHierarchy | None:
    """None where it refuses the text or does not come to its end."""
    notices: list[Notice] = []
    tokens = Tokens(Lines(io.BytesIO(text), Encoding("utf-8", 0)))
    try:
        skeleton = read_hierarchy(tokens, limits, notices)
        if tokens.peek() is not None:
            return None
    except McmlError:
        return None
    return SharedHierarchy(skeleton, tuple(notices), tokens.here.line or 0)


@given(st.integers(0, 1 << 30))
def test_both_readers_agree(seed: int) -> None:
    for place in range(8):
        agree(random.Random(seed + place), place % 4)


def agree(chance: random.Random, damages: int) -> None:
    text = hierarchy(chance)
    for _ in range(damages):
        text = damaged(text, chance)
    text += "\n"
    wanted = by_the_grammar(text.encode(), LIMITS)
    if wanted is None:
        assert read_plain(text, LIMITS) is None or "\0" in text
        with pytest.raises(McmlError):
            shared_hierarchy.__wrapped__(text.encode(), "utf-8", LIMITS)
    else:
        assert shared_hierarchy.__wrapped__(text.encode(), "utf-8", LIMITS) == wanted


def test_most_of_what_programs_write_is_plain() -> None:
    roomy = Limits()
    texts = [hierarchy(random.Random(seed)) for seed in range(300)]
    plain = [text for text in texts if read_plain(text, roomy) is not None]
    assert all(text in plain for text in texts if " Arm" not in text and "1e-3" not in text)
    assert len(plain) > 100


def joint(name: str, *children: str) -> str:
    return f"JOINT {name}\n{{\nOFFSET 0 0 0\n{''.join(children)}}}\n"


@pytest.mark.parametrize(
    ("body", "is_refused"),
    [
        (joint("a", joint("b", joint("c", joint("d")))), False),
        (joint("a", joint("b", joint("c", joint("d", joint("e"))))), True),
        ("".join(joint(f"j{n}") for n in range(11)), False),
        ("".join(joint(f"j{n}") for n in range(12)), True),
        (joint("n" * 20), False),
        (joint("n" * 21), True),
    ],
)
def test_limits_are_the_other_readers(body: str, is_refused: bool) -> None:
    text = f"HIERARCHY\n{joint('hips', body).replace('JOINT', 'ROOT', 1)}"
    assert (read_plain(text, LIMITS) is None) == is_refused
    assert (by_the_grammar(text.encode(), LIMITS) is None) == is_refused
