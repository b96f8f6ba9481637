"""The content models of `mcml.dtd`, read from its text: what an element must hold, and which sequences it may.

Written anew for the tests, from the text of the DTD to regular expressions of Python, so that it shares nothing with
libxml2 nor with `mcml.language.content`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache

from mcml.resources import dtd_path

_ELEMENT = re.compile(r"<!ELEMENT\s+(\S+)\s+(.*?)>", re.DOTALL)
_ATTRIBUTES = re.compile(r"<!ATTLIST\s+(\S+)\s+(.*?)>", re.DOTALL)
_ATTRIBUTE = re.compile(r"(\S+)\s+(CDATA|\([^)]*\))\s+#(REQUIRED|IMPLIED)")
_TOKEN = re.compile(r"[A-Za-z_]+[?*+]?|\)[?*+]?|[(,|]")


@cache
def models() -> dict[str, str]:
    """The content model of each element, as the DTD writes it."""
    return {name: model.strip() for name, model in _ELEMENT.findall(_declarations())}


@cache
def attributes() -> dict[str, dict[str, tuple[str, bool]]]:
    """Of each element its attributes: their type as the DTD writes it, and whether they are required."""
    lists = {name: _ATTRIBUTE.findall(declared) for name, declared in _ATTRIBUTES.findall(_declarations())}
    return {name: {own: (type_, kind == "REQUIRED") for own, type_, kind in found} for name, found in lists.items()}


def _declarations() -> str:
    return re.sub(r"<!--.*?-->", "", dtd_path().read_text(encoding="utf-8"), flags=re.DOTALL)


def required(parent: str) -> set[str]:
    """The children that stand in every valid element of that name, exactly once.

    They are those whose particle has no ?, * or + and stands in no choice nor in a group that has one.
    """
    model = models()[parent]
    if model == "EMPTY" or "#PCDATA" in model:
        return set()
    depth = 0
    found = set()
    for token in _TOKEN.findall(model):
        depth += token == "("
        if depth == 1 and token.isidentifier():
            found.add(token)
        depth -= token[0] == ")"
    if "|" in re.sub(r"(?<=.)\([^()]*\)", "", model) or model[-1] != ")" or "+" in model:
        raise AssertionError(f"{parent} has a model that this reading does not know: {model}")
    return found


def may_have(name: str, values: Mapping[str, str]) -> bool:
    """Whether an element of that name may have exactly these attributes."""
    declared = attributes().get(name, {})
    if any(needed and own not in values for own, (_, needed) in declared.items()):
        return False
    return all(
        own in declared and (declared[own][0] == "CDATA" or value in re.findall(r"\w+", declared[own][0]))
        for own, value in values.items()
    )


def may_hold(parent: str, children: list[str]) -> bool:
    """Whether the sequence of children fits the content model of the parent."""
    model = models().get(parent)
    if model is None:
        return False
    if model == "EMPTY" or "#PCDATA" in model:
        return not children
    return _pattern(model).fullmatch("".join(f"<{child}>" for child in children)) is not None


@cache
def _pattern(model: str) -> re.Pattern[str]:
    parts = []
    for token in _TOKEN.findall(model):
        name = token.rstrip("?*+")
        parts.append(f"(?:<{name}>){token[len(name) :]}" if name[0].isalpha() else token.replace("(", "(?:"))
    return re.compile("".join(part for part in parts if part != ","))
