"""Documents with one element that the DTD requires removed, renamed, or swapped with a neighbour are refused.

Which elements it requires, and which changes it allows, is read from the text of the DTD (`tests.mcml.models`), not
asked of the validators that are under test.
"""

from __future__ import annotations

import copy
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import pytest
from lxml import etree

from mcml.errors import DocumentError
from mcml.language import dtd
from mcml.language.reader import read_document
from tests.mcml.models import may_have, may_hold, models, required
from tests.mcml.samples import captures, generated, hand_written

LEAST_SHARE = 0.95


@dataclass(frozen=True)
class Mutant:
    """A document with one change. required: whether it hit a required element. allowed: whether the DTD allows it."""

    what: str
    document: bytes
    required: bool
    allowed: bool


def mutants(document: bytes, new_names: tuple[str, ...] = ()) -> Iterator[Mutant]:
    """Each element removed, renamed to an unknown name and its neighbours', swapped with both neighbours.

    new_names: to which required elements are renamed as well.
    """
    root: Any = etree.fromstring(document)
    for place, node in enumerate(root.iter()):
        parent = node.getparent()
        needs = set() if parent is None else required(parent.tag)
        needed = parent is None or node.tag in needs
        before, after = node.getprevious(), node.getnext()
        changes = [("remove", "")] if parent is not None else []
        names = [
            "nothing",
            *(new_names if needed else ()),
            *(other.tag for other in (before, after) if other is not None),
        ]
        changes += [("rename", name) for name in dict.fromkeys(names) if name != node.tag]
        if after is not None and after.tag != node.tag:
            changes.append(("swap", ""))
        for kind, name in changes:
            tree = copy.deepcopy(root)
            target = next(element for index, element in enumerate(tree.iter()) if index == place)
            above = target.getparent()
            if kind == "remove":
                above.remove(target)
            elif kind == "rename":
                target.tag = name
            else:
                above.insert(above.index(target), target.getnext())
            allowed = tree.tag == "mcml" and (above is None or _fits(above)) and (kind != "rename" or _fits(target))
            hit = needed or (kind == "swap" and after.tag in needs)
            yield Mutant(f"{kind} {node.tag} {name}".strip(), etree.tostring(tree), hit, allowed)


def _fits(node: Any) -> bool:
    """Whether an element's children, text and attributes are those that its declaration allows."""
    if node.tag not in models() or not may_hold(node.tag, [child.tag for child in node]):
        return False
    texts = [node.text, *(child.tail for child in node)]
    model = models()[node.tag]
    if model == "EMPTY" and node.text is not None:
        return False
    if "#PCDATA" not in model and any(text and text.strip() for text in texts):
        return False
    return may_have(node.tag, dict(node.attrib))


def accepted_by_reader(document: bytes) -> bool:
    try:
        for _ in read_document(BytesIO(document)).clip.blocks():
            pass
    except DocumentError:
        return False
    return True


def refusal(documents: list[bytes], new_names: tuple[str, ...] = ()) -> tuple[Counter[str], dict[str, int]]:
    """Counts of mutants of required elements, by who refused them; and those of the others, allowed or not."""
    counts: Counter[str] = Counter()
    kept: Counter[str] = Counter()
    for document in documents:
        for mutant in mutants(document, new_names):
            valid, read = not dtd.violations(mutant.document), accepted_by_reader(mutant.document)
            assert valid == mutant.allowed, (mutant.what, mutant.document)
            assert valid or not read, (mutant.what, mutant.document)
            if mutant.required:
                counts["all"] += 1
                counts["libxml2"] += not valid
                counts["reader"] += not read
                kept[mutant.what] += valid
            else:
                counts["others"] += 1
                counts["others, allowed"] += mutant.allowed
                counts["others, refused"] += not valid
    return counts, {what: count for what, count in kept.items() if count}


def test_what_the_dtd_requires() -> None:
    assert {parent: required(parent) for parent in models() if required(parent)} == {
        "mcml": {"header", "skeleton", "motion"},
        "bone": {"name"},
        "motion": {"frames"},
    }


@pytest.mark.parametrize("document", [*hand_written(), *captures()])
def test_whole_documents_are_valid_by_every_judge(document: bytes) -> None:
    root: Any = etree.fromstring(document)
    assert all(_fits(node) for node in root.iter())
    assert not dtd.violations(document)
    assert accepted_by_reader(document)


@pytest.mark.slow
def test_changes_of_required_elements_are_refused() -> None:
    counts, kept = refusal([*hand_written(), *captures(), *generated(3)])
    assert counts["all"] >= 300
    assert counts["libxml2"] >= LEAST_SHARE * counts["all"], kept
    assert counts["reader"] >= LEAST_SHARE * counts["all"], kept
    assert counts["others, allowed"] > 150
    assert counts["others, refused"] > 150


@pytest.mark.fuzz(seeds=1)
def test_changes_of_required_elements_are_refused_in_many_documents(seed: int) -> None:
    counts, kept = refusal([*hand_written(), *captures(), *generated(400, seed)], tuple(models()))
    assert counts["all"] >= 20_000
    assert counts["libxml2"] >= LEAST_SHARE * counts["all"], kept
    assert counts["reader"] >= LEAST_SHARE * counts["all"], kept
