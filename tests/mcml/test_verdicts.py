"""Two ways, one verdict: the streaming reader, the proof by frame shapes, and libxml2, on thousands of documents."""

from __future__ import annotations

from io import BytesIO
from random import Random

import pytest

from mcml.errors import DocumentError
from mcml.language import dtd
from mcml.language.reader import read_document
from tests.mcml.broken import (
    broken_documents,
    clip_verdict,
    leading_children,
    pool,
    rules_hold,
    shapes_verdict,
    with_changed_frames,
    with_changed_head,
)
from tests.mcml.samples import EMPTY


def readers_agree(seed: int, count: int) -> None:
    """The reader takes what libxml2 finds valid, unless it breaks a rule beyond the DTD; and nothing else."""
    accepted = refused = 0
    for document in broken_documents(seed, count):
        valid = not dtd.violations(document)
        try:
            for _ in read_document(BytesIO(document)).clip.blocks():
                pass
        except DocumentError:
            refused += 1
            assert not valid or not rules_hold(document), document
        else:
            accepted += 1
            assert valid, document
    assert min(accepted, refused) > count // 6


def shapes_agree(seed: int, count: int) -> None:
    """The head with one frame of each shape is valid exactly when the whole document is, by libxml2 both times."""
    random = Random(seed)
    whole = [document for document in pool() if b"<frame " in document]
    valid = 0
    for number in range(count):
        document = random.choice(whole)
        if number % 2:
            changed = with_changed_frames(random, document)
            proof = shapes_verdict(changed, leading_children(document))
        else:
            changed = with_changed_head(random, document)
            proof = clip_verdict(changed, document)
        verdict = not dtd.violations(changed)
        assert proof == verdict, changed
        valid += verdict
    assert count // 6 < valid < count - count // 6


def test_the_verdict_is_libxml2_s() -> None:
    readers_agree(seed=1, count=250)


def test_one_frame_of_each_shape_decides_like_the_whole() -> None:
    shapes_agree(seed=2, count=200)


@pytest.mark.parametrize("texts", [("x", "\n  "), ("\n  ", "x"), ("", "x"), ("x", "")])
def test_frames_with_text_are_another_shape_than_those_with_white_space(texts: tuple[str, str]) -> None:
    frames = "".join(f'<frame id="1">{text}</frame>' for text in texts).encode()
    document = EMPTY.replace(b"</frames>", b"</frames>" + frames)
    assert dtd.violations(document)
    assert not shapes_verdict(document, leading=1)


@pytest.mark.parametrize("texts", [("", " "), (" ", "")])
def test_white_space_in_an_empty_element_is_another_shape_than_none(texts: tuple[str, str]) -> None:
    frames = "".join(f'<frame id="1"><frame_bone name="a">{text}</frame_bone></frame>' for text in texts).encode()
    document = EMPTY.replace(b"</frames>", b"</frames>" + frames)
    assert dtd.violations(document)
    assert not shapes_verdict(document, leading=1)


@pytest.mark.fuzz(seeds=4)
def test_the_verdict_is_libxml2_s_many_times(seed: int) -> None:
    readers_agree(seed, count=3000)


@pytest.mark.fuzz(seeds=4)
def test_one_frame_of_each_shape_decides_like_the_whole_many_times(seed: int) -> None:
    shapes_agree(seed, count=3000)
