"""Names of joints: aliases of a project, and renaming joints of existing documents."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import DOCUMENT, PROJECT, TIME, shown
from mcml_schemas.request_body import RequestBody

_NAME = Field(min_length=1, max_length=1024)


class Alias(RequestBody):
    """source: a name in files; case and punctuation do not count. name: MCML's own, which it means."""

    model_config = ConfigDict(frozen=True)

    source: Annotated[str, _NAME]
    name: Annotated[str, _NAME]


class SavedAliases(RequestBody):
    """All aliases of a project."""

    model_config = ConfigDict(json_schema_extra=shown({"items": [{"source": "Hüfte", "name": "Root"}]}))

    items: list[Alias] = Field(min_length=1, max_length=10_000)


class AliasTable(BaseModel):
    """version: number of changes, 0 without any. author, changed: of the last one."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "project": PROJECT,
                "version": 2,
                "author": "local",
                "changed": TIME,
                "items": [{"source": "Hüfte", "name": "Root"}],
            }
        )
    )

    project: str
    version: int
    author: str
    changed: str
    items: list[Alias]


class Rename(BaseModel):
    """source: the joint's name in the file that it came from. A joint whose role alone changes keeps its name."""

    source: str
    before: str
    after: str
    role: str | None = Field(
        None, description="Purpose of a joint without a name of MCML's", exclude_if=lambda role: role is None
    )


class AppliedNames(BaseModel):
    """revision: the new revision of the document; the current one if nothing was renamed, or in a dry run."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "document": DOCUMENT,
                "revision": 3,
                "items": [{"source": "Neck", "before": "neck1", "after": "neck2"}],
            }
        )
    )

    document: str
    revision: int
    items: list[Rename]


class JointChoice(RequestBody):
    """joint: its present name in the document. name: MCML's own, null for the name in the file."""

    model_config = ConfigDict(frozen=True)

    joint: Annotated[str, _NAME]
    name: Annotated[str, _NAME] | None


class JointChoices(RequestBody):
    """Names that a person chose for joints of a document. Another joint with such a name gets the one in its file."""

    model_config = ConfigDict(json_schema_extra=shown({"items": [{"joint": "Hüfte", "name": "Root"}]}))

    items: list[JointChoice] = Field(min_length=1, max_length=10_000)
    remember: bool = Field(
        False, description="Add the names to those that the project defines, for files imported later"
    )
