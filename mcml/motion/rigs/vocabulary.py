"""Words in names of joints, in eleven languages, and the part of the body that each one names.

`words.csv` has a row for each language and part. `left`, `right` and `centre` are sides; `upper`, `lower`, `fore`,
`hind`, `front` change another word; `noise` has no meaning; `end`, `half`, HELPERS and APPENDAGES mark joints that are
not part of a person's body.
"""

from __future__ import annotations

import csv
import unicodedata
from collections.abc import Iterator
from functools import cache

from mcml.resources import rig_words_path

ENGLISH = "en"
HELPERS = frozenset(
    {"clothing", "control", "eye", "face", "face_part", "hair", "heel", "jaw", "prop", "soft_tissue", "tip"}
)
"""Parts of joints that stand for no bone of limbs and trunk, or only drive others."""
APPENDAGES = frozenset({"tail", "wing"})
_SHORT = 3
"""Letters of a Latin word up to which another language's words count only in a rig of that language."""


def normalise(text: str) -> str:
    """Small letters of one form: NFKC, Latin letters without accents, `ß` as `ss`; others stay composed."""
    if text.isascii():
        return text.lower()
    letters = []
    for letter in unicodedata.normalize("NFKC", text):
        bare = unicodedata.normalize("NFD", letter)[0]
        letters.append(bare if bare.isascii() and bare.isalpha() else letter)
    return "".join(letters).casefold()


@cache
def languages() -> dict[str, dict[str, tuple[str, ...]]]:
    """Of each language its words and the parts that each of them names."""
    found: dict[str, dict[str, list[str]]] = {}
    with rig_words_path().open(encoding="utf-8", newline="") as stream:
        for row in csv.DictReader(stream):
            words = found.setdefault(row["language"], {})
            for word in row["words"].split():
                words.setdefault(normalise(word), []).append(row["part"])
    return {language: {word: tuple(parts) for word, parts in words.items()} for language, words in found.items()}


class Vocabulary:
    """The words for a rig in a language.

    If a word exists in several languages, the rig's own comes first, then English. A short Latin word of a third
    language does not count: `te` is a hand only in Japanese, `d` is a side only in French or Spanish.
    """

    def __init__(self, language: str = ENGLISH) -> None:
        self.language = language
        self._parts = {word: parts for each in self._order() for word, parts in each}
        self._longest = max(map(len, self._parts))

    def _order(self) -> Iterator[list[tuple[str, tuple[str, ...]]]]:
        """Words of languages, the weakest claim first."""
        every = languages()
        for name in reversed(list(every)):
            if name not in (ENGLISH, self.language):
                yield [(word, parts) for word, parts in every[name].items() if not word.isascii() or len(word) > _SHORT]
        yield list(every[ENGLISH].items())
        yield list(every[self.language].items())

    def parts(self, word: str) -> tuple[str, ...]:
        """Return the parts that a normalised word names; empty for an unknown word."""
        return self._parts.get(word, ())

    def cut(self, piece: str) -> tuple[str, ...]:
        """A piece of a name as the fewest known words that use all its letters; the piece itself if none do.

        At most one letter for a side is at one end: `lhipjoint` is l hipjoint.
        """
        if piece in self._parts or len(piece) > _LONGEST:
            return (piece,)
        # The words up to each letter, without a side letter and with one.
        plain: list[tuple[str, ...] | None] = [(), *[None] * len(piece)]
        for end in range(1, len(piece) + 1):
            for start in range(max(0, end - self._longest), end):
                before, word = plain[start], piece[start:end]
                if before is None or not self._stands(word):
                    continue
                best = plain[end]
                if best is None or len(before) + 1 < len(best):
                    plain[end] = (*before, word)
        whole = plain[-1]
        if whole is not None:
            return whole
        if piece[0] in _SIDES and len(piece) > _SHORT - 1:
            rest = self.cut_plain(piece[1:])
            if rest:
                return (piece[0], *rest)
        before = plain[-2]
        if piece[-1] in _SIDES and before:
            return (*before, piece[-1])
        return (piece,)

    def cut_plain(self, piece: str) -> tuple[str, ...]:
        """The fewest known words without a letter of a side; empty if there are none."""
        words = self.cut(piece) if piece not in self._parts else (piece,)
        return words if all(self._stands(word) for word in words) else ()

    def _stands(self, word: str) -> bool:
        """Tell whether a word may be a piece of another: short Latin words occur in too many."""
        return word in self._parts and (not word.isascii() or len(word) >= _SHORT or word in _SHORT_ONES)


_LONGEST = 48
"""Letters of a piece that is cut: longer ones are no words."""
_SIDES = frozenset("lr")
_SHORT_ONES = frozenset({"up", "ik", "fk", "jt", "bn"})


@cache
def vocabulary(language: str = ENGLISH) -> Vocabulary:
    """The vocabulary of a language, made once."""
    return Vocabulary(language)
