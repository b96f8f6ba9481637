"""The content models of `mcml.dtd`, compiled, so that a document can be checked element by element as it streams.

Each model becomes an automaton with one state for each occurrence of a tag in the declaration (Glushkov 1961). XML
wants models to be deterministic, so a state and a tag give one next state, and an error is known at the element that is
wrong, with its line, before the document was read to the end.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from lxml import etree

from mcml.language.addresses import address_attribute
from mcml.resources import dtd_path

START = 0


@dataclass(frozen=True, slots=True)
class Declaration:
    """One element type.

    kind: "elements", "text" or "empty". steps: for each state, tag -> next state; state 0 is the start tag.
    accepting: states in which the element may end. required: attributes it must have. attributes: all it may have,
    with the values allowed, () for any.
    """

    name: str
    kind: str
    steps: tuple[Mapping[str, int], ...]
    accepting: frozenset[int]
    required: tuple[str, ...]
    attributes: Mapping[str, tuple[str, ...]]

    def attribute_error(self, attributes: Mapping[str, str]) -> str | None:
        """Return the error in an element's attributes, None if there is none."""
        for name, value in attributes.items():
            allowed = self.attributes.get(name)
            if allowed is None:
                return f"{self.name} has no attribute {name}; it may have {', '.join(self.attributes) or 'none'}"
            if allowed and value not in allowed:
                return f"{address_attribute(self.name, name)} is {value!r}; it must be {' or '.join(allowed)}"
        missing = [name for name in self.required if name not in attributes]
        return f"{self.name} needs the attribute {missing[0]}" if missing else None

    def child_error(self, state: int, tag: str) -> str:
        """Why `tag` cannot come now."""
        if self.kind != "elements":
            return f"{self.name} holds {'text only' if self.kind == 'text' else 'nothing'}; {tag} is not allowed in it"
        wanted = list(self.steps[state]) + [f"the end of {self.name}"] * (state in self.accepting)
        return f"{tag} is not allowed here in {self.name}; expected {' or '.join(wanted)}"

    def end_error(self, state: int) -> str | None:
        """Why the element cannot end now, None if it can."""
        if state in self.accepting:
            return None
        return f"{self.name} is not complete; expected {' or '.join(self.steps[state])}"


@cache
def declarations() -> Mapping[str, Declaration]:
    """Every element type of the language by its name."""
    with dtd_path().open("rb") as stream:
        dtd: Any = etree.DTD(stream)
    return {element.name: _declare(element) for element in dtd.iterelements()}


def _declare(element: Any) -> Declaration:
    attributes = {attribute.name: tuple(attribute.itervalues()) for attribute in element.iterattributes()}
    required = tuple(attribute.name for attribute in element.iterattributes() if attribute.default == "required")
    if element.type == "element":
        model = _Model()
        whole = model.compile(element.content)
        steps = [{model.tags[position]: position for position in whole.first}]
        steps += [
            {model.tags[after]: after for after in model.follow[position]} for position in range(1, len(model.tags))
        ]
        accepting = frozenset(whole.last | ({START} if whole.nullable else set()))
        return Declaration(element.name, "elements", tuple(steps), accepting, required, attributes)
    kind = "empty" if element.type == "empty" else "text"
    return Declaration(element.name, kind, ({},), frozenset({START}), required, attributes)


@dataclass(frozen=True, slots=True)
class _Ends:
    """The first and last elements of a part of a content model, and whether it may be left out."""

    nullable: bool
    first: set[int]
    last: set[int]


class _Model:
    """The places of one content model: `tags[p]` is at place p, `follow[p]` are the places that may come next."""

    def __init__(self) -> None:
        self.tags = [""]
        self.follow: list[set[int]] = [set()]

    def compile(self, content: Any) -> _Ends:
        if content.type == "element":
            self.tags.append(content.name)
            self.follow.append(set())
            place = {len(self.tags) - 1}
            part = _Ends(False, place, place)
        else:
            left, right = self.compile(content.left), self.compile(content.right)
            if content.type == "seq":
                self._join(left.last, right.first)
                part = _Ends(
                    left.nullable and right.nullable,
                    left.first | (right.first if left.nullable else set()),
                    right.last | (left.last if right.nullable else set()),
                )
            else:
                part = _Ends(left.nullable or right.nullable, left.first | right.first, left.last | right.last)
        if content.occur in ("mult", "plus"):
            self._join(part.last, part.first)
        return _Ends(part.nullable or content.occur in ("opt", "mult"), part.first, part.last)

    def _join(self, before: set[int], after: set[int]) -> None:
        for place in before:
            self.follow[place] |= after
