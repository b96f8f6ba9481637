"""Answers that are no model: content as bytes, and an upload of which nothing was stored."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from mcml import errors
from mcml.errors import Notice
from mcml_schemas.documents import FileProblem


@dataclass
class Content:
    """An answer of bytes, which are produced while they are sent.

    name: file name. size: number of bytes, if known. facts: additional information, by name. notices: messages for the
    user; reading the blocks may add more. shown: whether a browser may show it. seek: returns the blocks from a byte
    offset on, if this is faster than reading all before it. live: whether to send each block at once.
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
