"""Text that does not say its encoding is read in the one that its letters are plausible for."""

from __future__ import annotations

import pytest

from mcml.formats import FORMATS
from mcml.formats.format import ReadOptions
from mcml.formats.text.plausible_text import plausible_codecs
from mcml.testing import read
from tests.builders import bvh

WORDS = {
    "cp949": "골반 왼쪽무릎 머리 손목 춤추는_사람.bvh 걷기 한글_이름 똠방각하 기쁨 뒤돌아보기",
    "cp932": "腰 左足 右ひざ センター 上半身 歩行.bvh 踊り_01 走る 頭 左親指１ 日本語のファイル名",
    "cp950": "骨盆 左腳 右手 頭 走路 跳舞.bvh 中文檔案名稱 膝蓋 脊椎",
    "gb18030": "骨盆 左腿 右手 头 走路 跳舞.bvh 中文文件名 膝盖 脊椎",
    "latin-1": "Hüfte Fuß épaule tête Rücken Año mão höger Bär_läuft.bvh",
}


@pytest.mark.parametrize(("codec", "word"), [(codec, word) for codec, text in WORDS.items() for word in text.split()])
def test_single_words(codec: str, word: str) -> None:
    assert plausible_codecs(word.encode(codec), "latin-1")[0] == codec


@pytest.mark.parametrize("codec", WORDS)
def test_files(codec: str) -> None:
    first, second, third = WORDS[codec].split()[:3]
    data = bvh(2, names=(first, second, third)).decode().encode(codec)
    clip = read(FORMATS["bvh"], {"bvh": data}, ReadOptions())
    assert [joint.source_name for joint in clip.head.skeleton.joints] == [first, second, third]
    assert clip.head.sources[0].encoding == codec
    [said] = [notice.what for notice in clip.notices if "not UTF-8" in notice.what]
    for tried in ("CP949", "Shift-JIS", "Big5", "GB 18030", "Latin-1"):
        assert tried in said


def test_what_is_plausible_as_nothing_is_latin() -> None:
    data = bvh(2, names=("\u00a9 a\u00a4 ", "b", "c")).decode().encode("latin-1")
    clip = read(FORMATS["bvh"], {"bvh": data}, ReadOptions())
    assert clip.head.sources[0].encoding == "latin-1"


def test_letters_behind_the_first_lines_decide_too() -> None:
    """What is plausible at first but does not decode later is not taken."""
    names = ("Hips", "腰".encode("cp932").decode("latin-1"), "\u00fd\u00fe")
    data = bvh(2, names=names).decode().encode("latin-1")
    assert read(FORMATS["bvh"], {"bvh": data}, ReadOptions()).head.sources[0].encoding == "latin-1"


def test_ascii_is_nothing_to_guess() -> None:
    assert plausible_codecs(b"Hips\nKnee", "latin-1") == []
