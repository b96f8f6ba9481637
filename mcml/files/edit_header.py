"""Facts that people state of a document, put into its header: description, properties, unit, up axis."""

from __future__ import annotations

from collections.abc import Iterable

from mcml.errors import DocumentError
from mcml.files.check_names import check_property
from mcml.language.elements import Element, leaf
from mcml.language.lexical import escape
from mcml.language.vocabulary import HEADER_LEAVES_AFTER_UNITS, HEADER_LEAVES_BEFORE_UNITS
from mcml.motion.units import UNITS

UP_AXES = ("X", "Y", "Z")

_ORDER = [
    *HEADER_LEAVES_BEFORE_UNITS,
    "units",
    *HEADER_LEAVES_AFTER_UNITS,
    "description",
    "property",
    "source",
    "section",
    "comment",
]
"""The children of `header` in the order of `mcml.dtd`."""


def with_facts(
    document: Element,
    *,
    description: str | None = None,
    properties: Iterable[tuple[str, str, str]] | None = None,
    unit: str | None = None,
    up: str | None = None,
) -> Element:
    """Set facts of a document; None keeps a fact, "" and () remove it. Raises DocumentError for invalid values."""
    changes: dict[str, list[Element]] = {}
    if description is not None:
        changes["description"] = [leaf("description", escape(description.strip()))] if description.strip() else []
    if properties is not None:
        changes["property"] = [_property(*item) for item in properties]
    if unit is not None:
        changes["calibration_unit"] = [leaf("calibration_unit", checked_unit(unit))] if unit else []
    if up is not None:
        changes["global_axis_of_gravity"] = [leaf("global_axis_of_gravity", checked_axis(up))] if up else []
    if not changes:
        return document
    header = document.children[0]
    kept = [child for child in header.children if child.tag not in changes]
    children = sorted(
        [*kept, *(child for new in changes.values() for child in new)], key=lambda child: _ORDER.index(child.tag)
    )
    changed = Element(header.tag, dict(header.attributes), header.text, children)
    return Element(document.tag, document.attributes, document.text, [changed, *document.children[1:]])


def checked_unit(unit: str) -> str:
    """A length unit that can be converted. DocumentError."""
    if unit.lower() not in UNITS:
        raise DocumentError(f"Unknown unit {unit!r}.", remedy=f"Use one of: {', '.join(UNITS)}.")
    return unit


def checked_axis(axis: str) -> str:
    """X, Y or Z. DocumentError."""
    if axis.upper() not in UP_AXES:
        raise DocumentError(f"Unknown axis {axis!r}.", remedy="The up axis is X, Y or Z.")
    return axis.upper()


def checked_property(name: str, value: str, unit: str) -> tuple[str, str, str]:
    """A property with a name, trimmed. DocumentError."""
    if not name.strip():
        raise DocumentError("A property has no name.", remedy='Write name=value, such as "age=23".')
    check_property(name.strip(), value.strip(), unit.strip())
    return name.strip(), value.strip(), unit.strip()


def _property(name: str, value: str, unit: str) -> Element:
    name, value, unit = checked_property(name, value, unit)
    attributes = {"name": escape(name), "value": escape(value)}
    return Element("property", attributes | ({"unit": escape(unit)} if unit else {}))
