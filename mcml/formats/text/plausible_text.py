"""Guess the encoding of text: it must decode, and its letters must be plausible.

Encodings of East Asia decode nearly any bytes, so successful decoding has little meaning. Each has letters in common
use and rare letters, included for completeness (Hangul beyond the 2,350 syllables of KS X 1001, hanja there, the second
levels of JIS X 0208, Big5 and GB 2312): text in another encoding decodes to these rare letters.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Final

_NOT_ASCII = re.compile(rb"[^\r\n]*[\x80-\xff][^\r\n]*")
_LEAST: Final = 0.3
"""The mean weight of letters from which on they are plausible."""

_BODY: Final = frozenset(
    "골반왼오른쪽팔다리무릎발손머목허어깨척추가슴뼈팔꿈치엉덩이왼발목걷기뛰춤동작"
    "左右上下半身足腕手首肩頭肘膝腰胸指親人中薬小先捩全親体目舌髪腳腿臂頸骨盆盖头颈脚腕踝髋脊歩走舞蹈动作行"
    "センターひざじグループつま"
)
"""Letters of the words for parts of a body and for movements."""

_FREQUENT: Final = frozenset(
    "이다는을의에가고로하지기사도어리를시나서인대자은한해그정수아부제있장보전주일들과조라구상면스여만원동성게비국안무적"
    "까위학중관선할것간공유신생모경된연니세소마우미오내당물치방화식야라히체실재용외개업노발영명김교요트단강데거드계"
)
"""The syllables of Korean that are met most."""


def _korean(letter: str, raw: bytes) -> float:
    if "가" <= letter <= "힣":
        # Trail bytes below A1 are those of the extension to KS X 1001.
        rare = raw[0] < 0xB0 or raw[1] < 0xA1
        return -0.5 if rare else 1.0 if letter in _FREQUENT else 0.7
    return 0.3 if "ㄱ" <= letter <= "ㆎ" else -0.5


def _japanese(letter: str, raw: bytes) -> float:
    if len(raw) == 1:
        # Katakana of half width: every second byte of other encodings is one.
        return -0.4
    if "ぁ" <= letter <= "ヿ":
        return 1.0
    return 0.8 if 0x88 <= raw[0] <= 0x98 else 0.2 if raw[0] == 0x81 else -0.4


def _traditional(letter: str, raw: bytes) -> float:
    return 0.8 if 0xA4 <= raw[0] <= 0xC6 else 0.0 if 0xA1 <= raw[0] <= 0xA3 else -0.4


def _simplified(letter: str, raw: bytes) -> float:
    if len(raw) != 2 or raw[1] < 0xA1:
        return -0.5
    return 0.8 if 0xB0 <= raw[0] <= 0xD7 else 0.0 if raw[0] <= 0xA3 else -0.3


_EASTERN: Final[dict[str, Callable[[str, bytes], float]]] = {
    "cp949": _korean,
    "cp932": _japanese,
    "cp950": _traditional,
    "gb18030": _simplified,
}
_TITLES: Final = {
    "cp949": "CP949 (Korean)",
    "cp932": "CP932 (Shift-JIS, Japanese)",
    "cp950": "CP950 (Big5)",
    "gb18030": "GB 18030 (Chinese)",
    "latin-1": "Latin-1",
    "cp437": "CP437 (DOS)",
    "utf-8": "UTF-8",
}

EASTERN: Final = tuple(_EASTERN)
"""Encodings of East Asia that are tried, those that decode least first."""


def title_of(codec: str) -> str:
    """The name of a codec for people."""
    return _TITLES.get(codec, codec)


def plausible_codecs(text: bytes, western: str) -> list[str]:
    """The codecs that a text decodes in and whose letters are plausible, the most plausible first.

    western: that of Europe that is tried too, "latin-1" or "cp437".
    """
    lines = _NOT_ASCII.findall(text)
    scores = {codec: _score(lines, codec) for codec in (*EASTERN, western)}
    return sorted((codec for codec, score in scores.items() if score >= _LEAST), key=lambda codec: -scores[codec])


def _score(lines: Sequence[bytes], codec: str) -> float:
    """The mean weight of the letters that are not ASCII; -1 where the lines do not decode."""
    weigh = _EASTERN.get(codec)
    total, count = 0.0, 0
    for line in lines:
        try:
            text = line.decode(codec)
        except UnicodeDecodeError:
            return -1.0
        for place, letter in enumerate(text):
            if letter.isascii():
                continue
            count += 1
            if weigh is None:
                total += _western(text, place)
            else:
                total += weigh(letter, letter.encode(codec)) + (0.5 if letter in _BODY else 0.0)
    return total / count if count else -1.0


def _western(text: str, place: int) -> float:
    """Rate letters with accents, which appear among letters without."""
    letter = text[place]
    if not letter.isalpha() or letter > "\u024f":
        return -0.5
    beside = text[max(0, place - 1) : place] + text[place + 1 : place + 2]
    return 0.7 if any(other.isascii() and other.isalpha() for other in beside) else -0.3
