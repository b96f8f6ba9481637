"""All errors, in one short hierarchy, independent of HTTP. Every error has the problem, the place, and the remedy."""

from __future__ import annotations

import errno
import re
from dataclasses import dataclass, replace
from typing import Any


@dataclass(frozen=True, slots=True)
class Place:
    """Where in the input: a file, a line and a column (both from 1), an element or its address."""

    file: str | None = None
    line: int | None = None
    column: int | None = None
    element: str | None = None

    def __str__(self) -> str:
        spot = self.file or ""
        if self.line is not None:
            spot = f"{spot}:{self.line}" if spot else f"line {self.line}"
        if self.column is not None:
            spot = f"{spot}:{self.column}" if self.line is not None else f"{spot} column {self.column}".strip()
        if self.element:
            spot = f"{spot} ({self.element})" if spot else self.element
        return spot


class McmlError(Exception):
    """The root of the tree.

    what: the problem, one sentence without the place. at: the place. remedy: how to fix it, an imperative sentence.
    details: further facts for programs (plain JSON values).
    """

    def __init__(self, what: str, *, at: Place | None = None, remedy: str | None = None, **details: Any) -> None:
        super().__init__(what)
        self.what = what
        self.at = at
        self.remedy = remedy
        self.details = details

    def in_file(self, name: str) -> McmlError:
        """The same error with the file named, for a reader that knows only its stream."""
        if self.at is None or self.at.file is None:
            self.at = replace(self.at or Place(), file=name)
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        # Kinds of errors have different constructors; between processes an error is restored without them.
        return _as_it_was, (type(self), self.args, self.__dict__)

    def __str__(self) -> str:
        where = f"{self.at}: " if self.at and str(self.at) else ""
        end = "" if self.what.endswith((".", "?", "!")) else "."
        return f"{where}{self.what}" + (f"{end} {self.remedy}" if self.remedy else "")


def _as_it_was(kind: type[McmlError], arguments: tuple[Any, ...], state: dict[str, Any]) -> McmlError:
    error = kind.__new__(kind, *arguments)
    error.__dict__.update(state)
    return error


def kind_name(kind: type[McmlError]) -> str:
    """FormatError becomes "format-error": the anchor of the kind on the page of problems."""
    return re.sub(r"(?<!^)(?=[A-Z])", "-", kind.__name__).lower()


def kind_of(name: str) -> type[McmlError] | None:
    """Return the kind of error with a name, None for an unknown name."""
    kinds = [McmlError]
    for kind in kinds:
        kinds += kind.__subclasses__()
    return next((kind for kind in kinds if kind_name(kind) == name), None)


class FormatError(McmlError):
    """A file breaks the specification of its format."""


class UnsupportedError(McmlError):
    """A format, variant or feature that the repository knows and does not read or write."""


class DocumentError(McmlError):
    """An MCML document, or an edit of one, breaks `mcml.dtd` or the rules beyond it."""


class ConversionError(McmlError):
    """A motion that the target format cannot hold."""


class VocabularyError(McmlError):
    """A motion name that no body can perform, or that is not in the vocabulary where it must be."""


class QueryError(McmlError):
    """An XPath expression that does not parse, has no such function, or mixes types."""


class RequestError(McmlError):
    """An argument that an operation does not have, or a value that does not fit."""


class LimitError(McmlError):
    """More bytes, frames, depth, time or memory than the settings allow."""


class SizeError(LimitError):
    """A request for more than one answer may hold."""


class NotFoundError(McmlError):
    """No such document, frame, element or name."""


class ConflictError(McmlError):
    """The stored state is not the one the request was made for."""


class StoreError(McmlError):
    """The store is damaged or not at the schema this program needs."""


class DamageError(StoreError):
    """Stored data is damaged: a checksum differs."""


class UnavailableError(StoreError):
    """The store cannot be reached now, and may be soon: its server is down or starts, or all connections are taken."""


class ReplicaError(UnavailableError):
    """The replica became unreachable while it was read. The read can be repeated on the primary."""

    def __init__(self) -> None:
        super().__init__("The store's replica went away.", remedy="Retry: the store itself then answers.")


class ClashError(UnavailableError):
    """Two transactions waited for each other, so the database ended this one. Nothing of it was done."""

    def __init__(self) -> None:
        super().__init__("Another request was in the way of this one.", remedy="Send it again.")


class BusyError(McmlError):
    """The server is too busy. Nothing of the request was done."""

    def __init__(self, what: str) -> None:
        super().__init__(what, remedy="Ask again in some seconds.")


class ShareError(BusyError):
    """One client has too many waiting requests. waiting: their number."""

    def __init__(self, waiting: int) -> None:
        super().__init__(f"{waiting} requests of yours wait already.")


class AttemptsError(McmlError):
    """Too many attempts to sign in, or too many wrong current passwords. seconds: until the next attempt."""

    def __init__(self, seconds: int) -> None:
        super().__init__(
            "There were too many attempts to log in, or to give the password.",
            remedy=f"Try again in {seconds} seconds.",
        )
        self.seconds = seconds


class SpaceError(StoreError):
    """The disk is full. Nothing of the request was stored."""

    def __init__(
        self,
        what: str = "There is no room left on the disk.",
        remedy: str = "Make room on the server, then repeat the request.",
    ) -> None:
        super().__init__(what, remedy=remedy)


def is_full(error: OSError) -> bool:
    """Whether the system refused a write because the disk, or the user's share of it, is full."""
    return error.errno in (errno.ENOSPC, errno.EDQUOT)


class AccessError(McmlError):
    """The request lacks the right to do this."""


@dataclass(frozen=True, slots=True)
class Notice:
    """One line of a receipt: a guess, repair or loss of a reader, with its reason.

    kind: "guess" (a value that the file does not state), "repair" (a fix of the file), "warning" (important for the
    user) or "note".
    """

    kind: str
    what: str
    at: Place | None = None
