"""How many arguments a function takes."""

from __future__ import annotations

from mcml.errors import Place, QueryError
from mcml_service.xpath.language.functions import SAFE_FUNCTIONS


class ArityError(QueryError):
    """A function is called with a number of arguments that it does not take."""


def check_arity(name: str, count: int, column: int) -> None:
    """Raise ArityError for a wrong number of arguments."""
    signature = SAFE_FUNCTIONS[name]
    if not signature.takes(count):
        given = "1 is given" if count == 1 else f"{count} are given"
        raise ArityError(f"{name}() takes {signature.words}, {given}", at=Place(column=column))
