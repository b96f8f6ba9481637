"""Edits of elements."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import ADDRESS, FRAME_BONE, shown
from mcml_schemas.request_body import RequestBody

Path = Annotated[str, Field(min_length=1, max_length=10_000)]


class ElementChange(RequestBody):
    """New values of an element: attributes (null removes one) and the text of a leaf; omitted values do not change."""

    model_config = ConfigDict(
        json_schema_extra=shown({"attributes": {"Rx": "45.25", "SF": None}, "message": "a spike"}),
    )

    attributes: dict[str, str | None] = Field(default_factory=dict)
    text: str | None = None
    message: str = Field("", max_length=4096, description="Why, for the history")


class ChangeEdit(RequestBody):
    """Change attributes or text."""

    do: Literal["change"]
    xpath: Path
    attributes: dict[str, str | None] = Field(default_factory=dict)
    text: str | None = None


class DeleteEdit(RequestBody):
    """Delete elements or attributes."""

    do: Literal["delete"]
    xpath: Path
    renumber: bool = Field(False, description="Ids of frames that counted up by one do so again")


class ReplaceEdit(RequestBody):
    """Replace an element by others."""

    do: Literal["replace"]
    xpath: Path
    fragment: str = Field(description="One or more elements as XML")


class InsertEdit(RequestBody):
    """Insert elements beside one, or into it, at its end."""

    do: Literal["insert"]
    xpath: Path
    where: Literal["before", "after", "into"] = "into"
    fragment: str = Field(description="One or more elements as XML")


class MoveEdit(RequestBody):
    """Move an element beside another, or into it."""

    do: Literal["move"]
    xpath: Path
    to: Path
    where: Literal["before", "after", "into"] = "into"


Edit = Annotated[ChangeEdit | DeleteEdit | ReplaceEdit | InsertEdit | MoveEdit, Field(discriminator="do")]


class ElementEdits(RequestBody):
    """Edits that become one revision: all, or none.

    Every expression refers to the document before the first of them.
    """

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "edits": [
                    {"do": "change", "xpath": "/mcml/motion/frame[100]/frame_bone[3]", "attributes": {"Rx": "45.2"}},
                    {"do": "replace", "xpath": "/mcml/motion/frame[7]/frame_bone[3]", "fragment": FRAME_BONE},
                ],
                "message": "spikes",
            }
        ),
    )

    edits: list[Edit] = Field(min_length=1, max_length=10_000)
    many: bool = Field(False, description="Expressions may select several elements; each is edited so")
    renumber: bool = Field(True, description="Ids of frames that counted up by one do so again")
    message: str = Field("", max_length=4096, description="Why, for the history")


class Child(BaseModel):
    """An element without what is in it."""

    address: str = Field(description="A canonical XPath that finds it")
    name: str
    attributes: dict[str, str]
    text: str
    children: int = Field(description="How many elements are in it")


class ChildPage(BaseModel):
    """Children of an element, from number `first` on. total: how many it has."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "address": "/mcml/motion",
                "total": 1199,
                "first": 3,
                "items": [
                    {
                        "address": "/mcml/motion/frame[1]",
                        "name": "frame",
                        "attributes": {"id": "1"},
                        "text": "",
                        "children": 31,
                    }
                ],
            }
        )
    )

    address: str
    total: int
    first: int
    items: list[Child]


class TextPlace(BaseModel):
    """The place of a text in a document's text. line, column: from 1."""

    line: int
    column: int
    address: str = Field(description="Of the element whose line it is")
    frame: int | None = Field(None, description="Position of the frame that it is in")
    text: str = Field(description="Text around the match")


class TextFound(BaseModel):
    """The next place of a text; null if there is no further one, or if the time limit was reached."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "place": {
                    "line": 4711,
                    "column": 19,
                    "address": "/mcml/motion/frame[100]/frame_bone[3]",
                    "frame": 100,
                    "text": FRAME_BONE,
                },
                "next": None,
            }
        )
    )

    place: TextPlace | None = None
    next: int | None = Field(None, description="Line to go on from, where time was up")


class ElementEdited(BaseModel):
    """The result of an edit: the address of the (first) element, the number of elements, and the new revision."""

    model_config = ConfigDict(json_schema_extra=shown({"address": ADDRESS, "elements": 1, "revision": 2}))

    address: str
    elements: int = 1
    revision: int
