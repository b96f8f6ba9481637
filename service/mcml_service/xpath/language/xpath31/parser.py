"""The parser of XPath 3.1, elementpath's, without functions that see more than their arguments and the document."""

from __future__ import annotations

import re
from collections.abc import Iterator
from copy import copy
from decimal import Decimal
from itertools import product
from typing import Any

from elementpath.collations import UNICODE_CODEPOINT_COLLATION
from elementpath.datatypes import AnyURI, UntypedAtomic
from elementpath.exceptions import ElementPathError
from elementpath.tdop import Parser
from elementpath.xpath31 import XPath31Parser

from mcml.errors import McmlError, Place, QueryError
from mcml_service.xpath.language.xpath31 import collations  # noqa: F401 - they take the place of elementpath's
from mcml_service.xpath.language.xpath31.corrections import correct

_FUNCTIONS = "http://www.w3.org/2005/xpath-functions"
NAMESPACES = {
    "fn": _FUNCTIONS,
    "math": f"{_FUNCTIONS}/math",
    "map": f"{_FUNCTIONS}/map",
    "array": f"{_FUNCTIONS}/array",
    "xs": "http://www.w3.org/2001/XMLSchema",
    "err": "http://www.w3.org/2005/xqt-errors",
}
"""Prefixes that an expression may use."""

OUTSIDE = frozenset(
    {
        "doc", "doc-available", "collection", "uri-collection", "unparsed-text", "unparsed-text-lines",
        "unparsed-text-available", "json-doc", "environment-variable", "available-environment-variables", "transform",
        "load-xquery-module",
    }
)  # fmt: skip
"""Functions that read files, the network, or the environment."""

_CLASS = re.compile(r"<class '(?:[\w.]*\.)?(\w+?)(?:10)?'>")
_TYPES = {
    "str": "xs:string", "int": "xs:integer", "Integer": "xs:integer", "float": "xs:double", "Decimal": "xs:decimal",
    "bool": "xs:boolean", "Date": "xs:date", "DateTime": "xs:dateTime", "Time": "xs:time", "Duration": "xs:duration",
    "DayTimeDuration": "xs:dayTimeDuration", "YearMonthDuration": "xs:yearMonthDuration", "AnyURI": "xs:anyURI",
    "UntypedAtomic": "xs:untypedAtomic", "QName": "xs:QName", "HexBinary": "xs:hexBinary",
    "Base64Binary": "xs:base64Binary", "Float": "xs:float",
}  # fmt: skip
"""Types of values as XPath names them, by their classes."""
_MESSAGE = re.compile(r"(?:.*? at line (\d+), column (\d+): )?(?:\[err:(\w+)\] )?(.*)", re.DOTALL)


class XPath31(XPath31Parser):
    """XPath 3.1 as the repository offers it."""

    symbol_table = {  # noqa: RUF012 - of its class, as elementpath has it
        name: kind for name, kind in XPath31Parser.symbol_table.items() if name not in OUTSIDE
    }


class _Compared:
    """A general comparison.

    In XPath 1.0 compatibility mode (XPath 3.1 §3.7.2) operands are compared by their truth if one of them is a single
    boolean, and both items as numbers if one of them is a number, or for less and greater; but dates, durations and
    similar types are compared by their own type.
    """

    def iter_comparison_data(self, context: Any) -> Iterator[Any]:
        token: Any = self
        if not token.parser.compatibility_mode:
            yield from super().iter_comparison_data(context)  # type: ignore[misc]  # of the token that this is mixed into
            return
        sides = [list(token[place].atomization(context)) for place in (0, 1)]
        truths = [len(side) == 1 and isinstance(side[0], bool) for side in sides]
        if any(truths):
            # The effective boolean value of the items themselves: nodes are true, also where their text is empty.
            yield tuple(
                side[0] if is_truth else token.boolean_value(list(token[place].select(copy(context))))
                for place, side, is_truth in zip((0, 1), sides, truths, strict=True)
            )
            return
        is_ordered = token.symbol not in ("=", "!=")
        for left, right in product(*sides):
            if isinstance(left, int) and isinstance(right, int):
                yield left, right
            elif isinstance(left, _TEXTS) and isinstance(right, _TEXTS) and not is_ordered:
                yield str(left), str(right)
            elif isinstance(left, (*_TEXTS, *_NUMBERS)) and isinstance(right, (*_TEXTS, *_NUMBERS)):
                yield token.number_value(left), token.number_value(right)
            else:
                yield left, right


correct(XPath31.symbol_table)
_TEXTS = (str, UntypedAtomic, AnyURI)
_NUMBERS = (int, float, Decimal)
for _symbol in ("=", "!=", "<", "<=", ">", ">="):
    _kind = XPath31.symbol_table[_symbol]
    XPath31.symbol_table[_symbol] = type(_kind.__name__, (_Compared, _kind), {})
XPath31.build()


def _made(parser: type[XPath31], compatible: bool) -> XPath31:
    return parser(
        namespaces=dict(NAMESPACES), compatibility_mode=compatible, default_collation=UNICODE_CODEPOINT_COLLATION
    )


def read_tokens(text: str, *, compatible: bool, parser: type[XPath31] = XPath31) -> Any:
    """The tokens of an expression. compatible: in the mode compatible with XPath 1.0.

    elementpath's ordinary entry evaluates constants while parsing, which a hostile text makes last for minutes;
    `tdop.Parser.parse` only parses. Raises QueryError.
    """
    try:
        return Parser.parse(_made(parser, compatible), text)
    except ElementPathError as error:
        raise query_error(error, text) from None
    except (MemoryError, RecursionError, McmlError):
        raise
    except Exception as error:
        # Unexpected errors of the parser for a text are not faults of the server.
        raise QueryError("this is no XPath 3.1", at=Place(column=1), xpath_error="XPST0003") from error


def query_error(error: Exception, text: str = "") -> QueryError:
    """Return elementpath's error for an expression, with the W3C's code. text: the expression, for the column."""
    line, column, code, what = _MESSAGE.fullmatch(str(error)).groups()  # type: ignore[union-attr]  # it always matches
    place = None
    if text:
        token = getattr(error, "token", None)
        before = text.split("\n")[: int(line or 1) - 1]
        at = sum(len(one) + 1 for one in before) + int(column or 1)
        place = Place(column=token.span[0] + 1 if column is None and token is not None else at)
    details = {} if code is None else {"xpath_error": code}
    return QueryError(in_words(what), at=place, **details)


def in_words(message: str) -> str:
    """Rewrite a message of elementpath or Python, with XPath's names of types."""
    return _CLASS.sub(lambda found: _TYPES.get(found[1], found[1]), " ".join(message.split())).rstrip(".")
