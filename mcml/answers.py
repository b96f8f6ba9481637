"""Answers that are no model: content as bytes, and an upload of which nothing was stored."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from mcml import errors
from mcml.errors import Notice
from mcml_schemas.documents import FileProblem


@dataclass
class Content:
    """An answer that is no model: bytes as they are made.

    name: of the file that it would be. size: bytes, where known. facts: what is told beside it, by name. notices: what
    the user should know of it; more may come while it is read. shown: a browser may show it. seek: the same from a byte
    on, where that is not to read all before it. live: each block is worth being sent at once.
    """

    blocks: Iterator[bytes | memoryview]
    media_type: str
    name: str | None = None
    size: int | None = None
    facts: dict[str, str] = field(default_factory=dict)
    notices: Sequence[Notice] = ()
    shown: bool = False
    seek: Callable[[int], Iterator[bytes]] | None = None
    live: bool = False


class UploadError(errors.McmlError):
    """Nothing of an upload was stored. problems: of each file; the first speaks for all."""

    def __init__(self, problems: list[FileProblem]) -> None:
        first = problems[0].problem
        super().__init__(first.detail, remedy=first.remedy)
        self.problems = problems
