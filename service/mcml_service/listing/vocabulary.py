"""Values that many documents share, as numbers: each value is kept, and looked at, once."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from itertools import repeat
from operator import contains
from typing import Generic, NamedTuple, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from mcml_service.storage.lists.filtering import fold, forms_of

Mask: TypeAlias = NDArray[np.bool_]
Codes: TypeAlias = NDArray[np.int32]
Value = TypeVar("Value", bound=Hashable)

KNOWN_WORDS = 100
"""Words of which it is kept which values hold them."""


class Numbering(Generic[Value]):
    """Numbers of values, in the order in which they came. It only grows: states of a library share it."""

    def __init__(self) -> None:
        self.values: list[Value] = []
        self._codes: dict[Value, int] = {}

    def __len__(self) -> int:
        return len(self.values)

    def add(self, value: Value) -> None:
        """Process a new value."""

    def codes(self, values: Iterable[Value]) -> Codes:
        """Their numbers; values that are new get some. For one thread at a time."""
        numbers = []
        for value in values:
            code = self._codes.get(value)
            if code is None:
                self.add(value)
                self.values.append(value)
                code = self._codes[value] = len(self.values) - 1
            numbers.append(code)
        return np.array(numbers, np.int32)

    def code(self, value: Value) -> int | None:
        """The number of a value, None where it has none."""
        return self._codes.get(value)


class Vocabulary(Numbering[Value]):
    """Of values in whose texts words are looked for."""

    def __init__(self) -> None:
        super().__init__()
        self.characters = 0
        self._folded: list[str] = []
        self._words: dict[str, Mask] = {}

    def text_of(self, value: Value) -> str:
        """In which words are looked for."""
        return str(value)

    def add(self, value: Value) -> None:
        text = fold(self.text_of(value))
        self._folded.append(text)
        self.characters += len(text)

    def holding(self, word: str) -> Mask:
        """Which values hold a word, in any case."""
        known = self._words.get(word, np.empty(0, np.bool_))
        if len(known) < len(self._folded):
            rest = self._folded[len(known) :]
            mask = np.zeros(len(rest), np.bool_)
            for form in forms_of(word):
                mask |= np.fromiter(map(contains, rest, repeat(form)), np.bool_, len(rest))
            known = np.concatenate([known, mask])
            if len(self._words) >= KNOWN_WORDS:
                self._words.clear()
            self._words[word] = known
        return known


Property: TypeAlias = tuple[str, float | None, str | None]
"""Name, number if it is one, text if it is short."""


class PropertyColumns(NamedTuple):
    """Of each different property the code of its name, its number or NaN, and whether its text is short."""

    names: Codes
    numbers: NDArray[np.float64]
    is_short: Mask


class Properties(Vocabulary[Property]):
    """Different properties, with their names and numbers as columns too."""

    def __init__(self) -> None:
        super().__init__()
        self.names = Numbering[str]()
        self._columns = PropertyColumns(np.empty(0, np.int32), np.empty(0), np.empty(0, np.bool_))

    def text_of(self, value: Property) -> str:
        return value[2] or ""

    def columns(self) -> PropertyColumns:
        """The columns of all current properties. For one thread at a time."""
        known = self._columns
        if new := self.values[len(known.names) :]:
            self._columns = PropertyColumns(
                np.concatenate([known.names, self.names.codes(name for name, _, _ in new)]),
                np.concatenate([known.numbers, np.array([number for _, number, _ in new], np.float64)]),
                np.concatenate([known.is_short, np.array([text is not None for _, _, text in new], np.bool_)]),
            )
        return self._columns
