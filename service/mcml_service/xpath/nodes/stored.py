"""Columns that can be stored outside the process and restored."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Protocol, TypeVar


class Columns(Protocol):
    """Arrays, and lists of texts and numbers, by name; each is decoded on use."""

    def __getitem__(self, name: str) -> Any: ...


Self = TypeVar("Self", bound="Stored")


class Stored:
    """An object made only from the columns in STORED: other values are computed from them on use.

    A restored object decodes each column on first use, because few queries use all.
    """

    STORED: ClassVar[tuple[str, ...]] = ()

    def stored(self) -> Mapping[str, Any]:
        """Return the columns: arrays, or JSON values."""
        return {name: getattr(self, name) for name in self.STORED}

    @classmethod
    def restored(cls: type[Self], columns: Columns) -> Self:
        """The same that had these columns."""
        made = cls.__new__(cls)
        made.__dict__["_columns"] = columns
        made._begin()
        return made

    def _begin(self) -> None:
        """Prepare the place of computed values."""

    def __getattr__(self, name: str) -> Any:
        if name not in type(self).STORED or "_columns" not in self.__dict__:
            raise AttributeError(name)
        found = self.__dict__[name] = self.__dict__["_columns"][name]
        return found
