"""Check names and times from outside: every database must store and find them, and HTTP headers must hold them."""

from __future__ import annotations

import math
import re
from decimal import Decimal
from fractions import Fraction

from mcml.errors import DocumentError, LimitError, Place
from mcml.language.elements import Element, header_of
from mcml.language.lexical import is_decimal
from mcml.language.vocabulary import PROPERTY
from mcml.motion.clip import ClipHead

LONGEST_VALUE = 1 << 18
"""Limit of a property in characters: enough for the provenance of a motion made from thousands of documents."""

NAME_BYTES = 1024
"""Of a name in UTF-8: PostgreSQL indexes no longer rows than 2,700 bytes."""

_RATIO = re.compile(r"([0-9]{1,15}(?:\.[0-9]{1,15})?) ?/ ?([0-9]{1,15}(?:\.[0-9]{1,15})?)")
_CONTROL = re.compile("[\x00-\x1f\x7f\ud800-\udfff]")


def given_name(text: str, of: str) -> str:
    """A name that a user gives. DocumentError for an empty or long one, or one with control characters."""
    name = text.strip()
    if not name:
        raise DocumentError(f"The name of the {of} is empty.", remedy="Give it a name.")
    _check(name, f"The name of the {of}")
    return name


def file_name(text: str) -> str:
    """The name of a file without its folders, and without what a store or a zip cannot hold."""
    name = _CONTROL.sub("_", re.split(r"[/\\]", text)[-1]).strip()
    while len(name.encode()) > NAME_BYTES // 4:
        stem, dot, extension = name.rpartition(".")
        name = f"{stem[:-1]}{dot}{extension}" if stem and len(extension) < 16 else name[:-1]
    return "unnamed" if name in ("", ".", "..") else name


def name_of_file(text: str) -> str:
    """The name that a document gets from its file."""
    name = file_name(text)
    return name.rsplit(".", 1)[0].strip() or name


def check_frame_time(given: str | float | Fraction) -> str:
    """Return the seconds of a frame as MCML writes them. Raises DocumentError for an invalid time.

    given: a number, or a text such as 0.0083333 or 1/120. A decimal text does not change; other values become the
    shortest text of the same number.
    """
    text = _seconds(given)
    if text is None or len(text) > 64 or not 1e-9 <= float(text) < 1e6:
        raise DocumentError(
            f"frame_time {str(given)[:80]!r} is no time.", remedy="Give seconds a frame, such as 0.0083333 or 1/120."
        )
    return text


def _seconds(given: str | float | Fraction) -> str | None:
    """As a decimal text, None where it is no finite number."""
    if not isinstance(given, str):
        return _decimal(float(given))
    text = given.strip()
    parts = _RATIO.fullmatch(text)
    if parts is None:
        return text if is_decimal(text) else None
    above, below = map(Fraction, parts.groups())
    return _decimal(float(above / below)) if below else None


def _decimal(number: float) -> str | None:
    """The shortest text of a number, without an exponent."""
    return f"{Decimal(repr(number)):f}" if math.isfinite(number) else None


def check_head(document: Element, head: ClipHead, max_joints: int) -> None:
    """Check the rules for the head of an uploaded document beyond its definition. Raises DocumentError, LimitError."""
    if len(head.skeleton) > max_joints:
        raise LimitError(f"The skeleton has {len(head.skeleton)} joints, the limit is {max_joints}.")
    for joint in head.skeleton.joints:
        _check(joint.name, "The name of a bone")
    if len(document.attributes.get("version", "")) > 32:
        raise DocumentError("The version is longer than 32 characters.", at=Place(element="/mcml/@version"))
    rate = head.fields.get("dataframe_rate")
    for address, text in (("/mcml/motion/frametime", head.frame_time), ("/mcml/header/dataframe_rate", rate)):
        if text is not None and (len(text) > 64 or 0 < abs(float(text)) < 1e-9 or abs(float(text)) > 1e9):
            raise DocumentError(f"{text[:80]!r} is no time or rate.", at=Place(element=address))
    for item in header_of(document).all(PROPERTY):
        check_property(item.attributes["name"], item.attributes["value"], item.attributes.get("unit", ""))


def check_property(name: str, value: str, unit: str) -> None:
    """DocumentError for one that is too long."""
    if not 0 < len(name) <= 256 or len(value) > LONGEST_VALUE or len(unit) > 64:
        raise DocumentError(
            f"The property {name[:80]!r} is too long.",
            remedy=f"A name has 1 to 256 characters, a value up to {LONGEST_VALUE}, a unit up to 64.",
        )


def _check(name: str, what: str) -> None:
    if _CONTROL.search(name):
        raise DocumentError(f"{what} holds a control character: {name[:80]!r}.", remedy="Leave it out.")
    if len(name.encode()) > NAME_BYTES:
        raise DocumentError(f"{what} is longer than {NAME_BYTES} bytes.", remedy="Give a shorter one.")
