"""Names of joints as words: split at punctuation, capitals, digits and scripts, cut into known words, without noise.

Prefixes of nearly all names of a rig, and repeated words, have no meaning for a joint and are left out.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from mcml.motion.rigs.vocabulary import ENGLISH, HELPERS, Vocabulary, languages, normalise, vocabulary

SIDES = frozenset({"left", "right"})
_FIRST = 0.85
"""Share of the names: a first word this frequent is the rig's prefix, not the joint's."""
_OFTEN = 12
"""Times that an unknown word may occur before it is noise."""
_LANGUAGE = 3, 0.1
"""Different words of a language, and the share of names with one of them, that make it the rig's."""
_MOST_LETTERS = 200
"""Letters of a name that are read."""

_PIECES = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[0-9]+|[가-힣]+|[぀-ヿ㐀-鿿ー]+|[^\W\d_a-zA-Z가-힣぀-ヿ㐀-鿿]+|[0-9]")
_LIMB_PARTS = frozenset(
    [
        "clavicle",
        "shoulder",
        "upper_arm",
        "arm",
        "forearm",
        "wrist",
        "hand",
        "palm",
        "fingers",
        "hip",
        "hip_connector",
        "thigh",
        "leg",
        "shin",
        "ankle",
        "foot",
        "toe",
    ]
)


@dataclass(frozen=True, slots=True)
class Word:
    """A word of a name.

    parts: the parts that it names, empty for an unknown word. glued: whether it follows the previous word without a
    gap. Digits are words too, and name nothing.
    """

    text: str
    parts: tuple[str, ...] = ()
    glued: bool = False

    @property
    def is_number(self) -> bool:
        return self.text.isdigit()


Words = tuple[Word, ...]


def split(name: str) -> list[tuple[str, bool]]:
    """Normalised pieces of a name, and whether each follows the one before it without a gap.

    Only the text after the last `:`, `|` or `/` is used, without brackets.
    """
    bare = re.split(r"[:|/]", name.strip().rstrip(":|/"))[-1][:_MOST_LETTERS]
    bare = re.sub(r"\[[^\]]*\]", " ", bare) if not bare.startswith("[") else bare
    bare = _without_accents(bare)
    end, pieces = -1, []
    for match in _PIECES.finditer(bare):
        pieces.append((normalise(match.group()), match.start() == end))
        end = match.end()
    return pieces


def _without_accents(text: str) -> str:
    """As `normalise`, capitals kept."""
    if text.isascii():
        return text
    return "".join(
        normalise(letter).upper() if letter.isupper() and len(normalise(letter)) == 1 else normalise(letter)
        for letter in text
    )


def read_words(names: Sequence[str]) -> tuple[list[Words], str]:
    """The words of each name, and the language of the rig."""
    pieces = [split(name) for name in names]
    language = _language(pieces)
    words = _known(pieces, vocabulary(language))
    for _ in range(4):
        shorter = _without_first(words)
        if shorter == words:
            break
        words = shorter
    return _without_noise(words), language


def _language(pieces: Sequence[Sequence[tuple[str, bool]]]) -> str:
    every = languages()
    english = vocabulary()
    best, most = ENGLISH, 0
    distinct = {piece for name in pieces for piece, _ in name if not piece.isdigit()}
    for language, own in every.items():
        if language == ENGLISH:
            continue
        words = vocabulary(language)
        telling = {
            piece: {
                word
                for word in words.cut(piece)
                if word in own and (len(word) > 1 or not word.isascii()) and not _is_english(english, word)
            }
            for piece in distinct
        }
        different = len(set().union(*telling.values())) if telling else 0
        count = sum(any(telling.get(piece) for piece, _ in name) for name in pieces)
        if different >= _LANGUAGE[0] and count >= _LANGUAGE[1] * len(pieces) and different > most:
            best, most = language, different
    return best


def _is_english(english: Vocabulary, word: str) -> bool:
    return word in languages()[ENGLISH] or (
        len(word) > 1
        and word.isascii()
        and all(len(part) > 1 and part in languages()[ENGLISH] for part in english.cut(word))
    )


def _known(pieces: Sequence[Sequence[tuple[str, bool]]], words: Vocabulary) -> list[Words]:
    every = Counter(piece for name in pieces for piece, _ in {each[0]: each for each in name}.values())
    often = 0.5 * len(pieces)
    cuts: dict[str, tuple[str, ...]] = {}
    flags = (
        every["joint"] > often,
        ("le" in every) and ("ri" in every),
        "lf" in every and "rt" in every and not {"lh", "rh"} & every.keys(),
        not {"lu", "ru"}.isdisjoint(every),
    )
    result = []
    for name in pieces:
        texts: list[tuple[str, bool]] = []
        for text, glued in _join_words(name, words, flags[0]):
            if text not in cuts:
                cuts[text] = words.cut(text)
            for place, word in enumerate(cuts[text]):
                texts.append((word, glued or place > 0))
        result.append(_split_sides(texts, words, flags))
    return result


def _join_words(
    name: Sequence[tuple[str, bool]], words: Vocabulary, joint_is_noise: bool
) -> Iterable[tuple[str, bool]]:
    """Pieces that make one word together, such as Up Leg or collar bone, as that word."""
    place = 0
    while place < len(name):
        taken = 1
        for count in (3, 2):
            some = [piece for piece, _ in name[place : place + count]]
            if len(some) < count or not SIDES.isdisjoint(words.parts(some[0])):
                continue
            if joint_is_noise and "joint" in some:
                continue
            if words.parts("".join(some)) and "".join(some).isalpha():
                taken = count
                break
        yield "".join(piece for piece, _ in name[place : place + taken]), name[place][1]
        place += taken


def _split_sides(texts: Sequence[tuple[str, bool]], words: Vocabulary, flags: tuple[bool, bool, bool, bool]) -> Words:
    """Split words into sides and parts.

    Single letters are interpreted by their neighbours: LU Arm is a left upper arm, and if another word has the side,
    the l of `larm` means lower.
    """
    _, le_and_ri, lf_and_rt, upper_too = flags
    result: list[Word] = []
    for place, (text, glued) in enumerate(texts):
        after = texts[place + 1][0] if place + 1 < len(texts) else ""
        limb = not {"arm", "leg"}.isdisjoint(words.parts(after))
        letters = "ufl" if "arm" in words.parts(after) else "ul"
        parts = words.parts(text)
        if text in ("le", "ri"):
            parts = ("left" if text == "le" else "right",) if le_and_ri else ()
        elif text == "lf" and lf_and_rt:
            parts = ("left",)
        elif limb and len(text) == 2 and text[0] in "lr" and text[1] in letters and (text[1] != "l" or upper_too):
            result.append(Word(text[0], words.parts(text[0]), glued))
            text, glued = text[1], True
            parts = ("upper",) if text == "u" else ("lower",)
        elif limb and text in letters and text in "uf":
            parts = ("upper",) if text == "u" else ("lower",)
        result.append(Word(text, parts, glued))
    for place, word in enumerate(result[:-1]):
        if word.text == "l" and result[place + 1].glued and {"arm", "leg"} & set(result[place + 1].parts):
            others = [each for other, each in enumerate(result) if other != place]
            if any(SIDES & set(each.parts) for each in others):
                result[place] = replace(word, parts=("lower",))
    return tuple(result)


def _without_first(words: list[Words]) -> list[Words]:
    """Remove the first word of nearly all names, unless it is a side or part of a limb."""
    firsts = Counter(name[0].text for name in words if name)
    if len(words) < 3 or not firsts:
        return words
    text, count = firsts.most_common(1)[0]
    parts = next(set(name[0].parts) for name in words if name and name[0].text == text)
    if count < _FIRST * len(words) or parts & (SIDES | _LIMB_PARTS):
        return words
    return [name[1:] if name and name[0].text == text else name for name in words]


def _without_noise(words: list[Words]) -> list[Words]:
    counts = Counter(text for name in words for text in {word.text for word in name})
    parts = {word.text: set(word.parts) for name in words for word in name}
    noise = set()
    for text, count in counts.items():
        known = parts[text]
        if (
            (not known and not text.isdigit() and (count > 0.5 * len(words) or count > _OFTEN))
            or (known and known <= {"noise"})
        ) or (
            known & (HELPERS | {"half", "end", "root"})
            and not known & (SIDES | {"centre"})
            and count > 0.6 * len(words) > 3
        ):
            noise.add(text)
    if parts.keys() & {"joint", "jnt", "jt"} and sum(counts[text] for text in ("joint", "jnt", "jt")) > 0:
        noise |= {"joint", "jnt", "jt"}
    return [tuple(word for word in name if word.text not in noise) for name in words]
