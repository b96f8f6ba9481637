"""Expressions of XPath 2.0 and later on the XML of a document, by Saxon in processes with limits of time and memory."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from mcml.errors import QueryError, StoreError
from mcml_service.xpath.limits import Limits
from mcml_service.xpath.xml.evaluate import Evaluator, Node

_SPECIAL = {"NaN": math.nan, "Infinity": math.inf, "-Infinity": -math.inf}


@dataclass(frozen=True, slots=True)
class Items:
    """A page of a sequence: nodes and atomic values in its order. total: how many there are on all pages."""

    items: tuple[Node | float | str | bool, ...]
    total: int


class Saxon(Evaluator):
    """A pool of processes as that of libxml2."""

    program = "mcml_service.xpath.xml.saxon_worker"

    def items(
        self,
        text: str,
        document: Iterable[bytes],
        *,
        variables: Mapping[str, str | float | bool],
        offset: int,
        limit: int,
        limits: Limits | None = None,
    ) -> Items:
        """The value of an expression that has been checked (`language/written.py`), the document as context item.

        Raises QueryError where Saxon refuses the expression or is not installed, else as `evaluate` does.
        """
        if not installed():
            raise QueryError(
                "This expression needs XPath 2.0, and Saxon is not installed.",
                remedy="Install the extra xpath2 (pip install 'mcml-repository[xpath2]'), or ask in XPath 1.0.",
            )
        request = {"expression": text, "variables": dict(variables), "limit": limit, "offset": offset}
        answer = self.ask(request, document, limits)
        if answer.get("error") == "expression":
            raise QueryError(f"Saxon refuses the expression: {answer['message']}")
        if answer.get("error"):
            raise StoreError(f"The document is not well-formed: {answer['message']}")
        return Items(tuple(_read(*item) for item in answer["items"]), answer["total"])


def installed() -> bool:
    """Whether Saxon can be asked."""
    return importlib.util.find_spec("saxonche") is not None


def _read(kind: str, *value: str | float | bool) -> Node | float | str | bool:
    if kind == "node":
        return Node(*map(str, value))
    if kind == "number" and isinstance(value[0], str):
        return _SPECIAL[value[0]]
    return value[0]
