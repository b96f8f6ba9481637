"""Live events of the repository."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import DOCUMENT, PROJECT, TIME, shown


class DocumentEvent(BaseModel):
    """A new revision; the data of events `document` and `label`."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "document": DOCUMENT,
                "revision": 2,
                "operation": "label",
                "name": "walk",
                "project": PROJECT,
                "author": "kim",
                "time": TIME,
            }
        )
    )

    document: str
    revision: int
    operation: str = Field(description="As the history has it: import, edit, frames, label, delete …")
    name: str
    project: str
    author: str
    time: str
