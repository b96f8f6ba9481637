"""Columns that can be kept outside of the process and had back as they were."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Protocol, TypeVar


class Columns(Protocol):
    """Arrays, and lists of texts and numbers, by name; each is decoded when it is asked for."""

    def __getitem__(self, name: str) -> Any: ...


Self = TypeVar("Self", bound="Stored")


class Stored:
    """What is made of the columns that STORED names alone: all else is worked out of them when it is needed.

    Of one that was restored a column is decoded when it is first looked at: few questions look at all.
    """

    STORED: ClassVar[tuple[str, ...]] = ()

    def stored(self) -> Mapping[str, Any]:
        """The columns: arrays, or what JSON can say."""
        return {name: getattr(self, name) for name in self.STORED}

    @classmethod
    def restored(cls: type[Self], columns: Columns) -> Self:
        """The same that had these columns."""
        made = cls.__new__(cls)
        made.__dict__["_columns"] = columns
        made._begin()
        return made

    def _begin(self) -> None:
        """Where what is worked out later is kept."""

    def __getattr__(self, name: str) -> Any:
        if name not in type(self).STORED or "_columns" not in self.__dict__:
            raise AttributeError(name)
        found = self.__dict__[name] = self.__dict__["_columns"][name]
        return found
