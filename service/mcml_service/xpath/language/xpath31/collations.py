"""Collations: by code points, ASCII without case, and the strengths of the Unicode Collation Algorithm, approximated.

elementpath compares by the locale of the process, which is one for all threads, needs locales that few machines have,
and leaves a lock behind if the locale does not exist. Here a collation is a key of each text:

- primary: letters alone, without accents and case; secondary: without case; others: as it is, composed (NFC).
- any other name is refused with FOCH0002, as is a UCA with `fallback=no`.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable
from typing import Any
from urllib.parse import urlsplit

from elementpath import compare
from elementpath.collations import UNICODE_COLLATION_BASE_URI, CollationManager
from elementpath.exceptions import xpath_error
from elementpath.xpath2 import _xpath2_functions
from elementpath.xpath31 import _xpath31_functions


def _letters(text: str) -> str:
    apart = unicodedata.normalize("NFKD", text)
    return "".join(letter for letter in apart if not unicodedata.combining(letter)).casefold()


def _composed(text: str) -> str:
    return unicodedata.normalize("NFC", text)


_KEYS: dict[str, Callable[[str], str]] = {"primary": _letters, "1": _letters}
_KEYS |= dict.fromkeys(("secondary", "2"), lambda text: _composed(text).casefold())


class Collations(CollationManager):
    """A collation by its name. Raises FOCH0002."""

    def __init__(self, collation: str | None, token: Any = None) -> None:
        super().__init__(collation, token)
        if self.lc_collate is None:
            return
        self.lc_collate = None
        parts = urlsplit(str(collation))
        said = dict(part.partition("=")[::2] for part in parts.query.split(";"))
        if not str(collation).startswith(UNICODE_COLLATION_BASE_URI) or said.get("fallback") == "no":
            raise xpath_error("FOCH0002", f"the collation {collation!r} is not known", token)
        key = _KEYS.get(said.get("strength", ""), _composed)
        if said.get("alternate") in ("shifted", "blanked"):
            whole = key
            key = lambda text: whole("".join(one for one in text if unicodedata.category(one)[0] not in "PZS"))  # noqa: E731
        self.strxfrm = key
        self.strcoll = lambda one, other: (key(one) > key(other)) - (key(one) < key(other))


for _module in (compare, _xpath2_functions, _xpath31_functions):
    _module.CollationManager = Collations  # type: ignore[attr-defined]  # they import it by its name
