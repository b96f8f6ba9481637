"""Damaged files of every format, in process: read whole, or refused in words of ours; never anything else."""

from __future__ import annotations

import io
import random
import re
import warnings

import numpy as np
import pytest

from mcml.errors import McmlError
from mcml.formats import FORMATS
from mcml.formats.format import Limits, ReadOptions, SourceFile
from mcml.language.reader import read_document
from mcml.testing import frames
from tests.builders import ASF, HTR, MCML, TRC, amc, bvh, c3d_file
from tests.c3d_writer import DEC, MIPS, c3d_bytes

FILES: dict[str, list[dict[str, bytes]]] = {
    "bvh": [{"bvh": bvh(5)}, {"bvh": bvh(2, names=("Hips", "Neck", "Neck1", "Head"))}],
    "asf-amc": [{"asf": ASF, "amc": amc(3)}],
    "htr": [{"htr": HTR}],
    "trc": [{"trc": TRC}],
    "c3d": [
        {"c3d": c3d_file()},
        {"c3d": c3d_bytes(np.ones((9, 2, 3)), scale=0.1, processor=MIPS, analog=np.ones((9, 4)), samples=2)},
        {"c3d": c3d_bytes(np.ones((4, 3, 3)), processor=DEC)},
    ],
    "mcml": [{"mcml": MCML}],
}
NUMBERS = [b"1e308", b"-1.8e308", b"0", b"-1", b"nan", b"1,5", b"9" * 30, b"0." + b"3" * 150, b"1e-400", b"65536", b""]
LIMITS = Limits(joints=200, frames=5000, values=100_000, text=100_000)


def damaged(data: bytes, chance: random.Random) -> bytes:
    spoilt = bytearray(data)
    for _ in range(chance.choice((1, 1, 2, 6))):
        place = chance.randrange(len(spoilt) + 1)
        match chance.randrange(7):
            case 0:
                spoilt[place : place + 1] = bytes([chance.randrange(256)])
            case 1:
                del spoilt[place : place + chance.choice((1, 4, 100))]
            case 2:
                spoilt[place:place] = chance.randbytes(chance.choice((1, 4, 40)))
            case 3:
                del spoilt[place:]
            case 4:
                other = chance.randrange(len(spoilt) + 1)
                spoilt[place:place] = spoilt[other : other + chance.choice((1, 20, 400))]
            case 5:
                spoilt[place : place + 2] = chance.choice((b"\0\0", b"\xff\xff", b"\x7f\xff", b"\r\n"))
            case _:
                found = list(re.finditer(rb"-?[0-9]+(?:\.[0-9]+)?", spoilt[:20_000]))
                if found:
                    number = chance.choice(found)
                    spoilt[number.start() : number.end()] = chance.choice(NUMBERS)
    return bytes(spoilt)


def read_or_refuse(format_name: str, files: dict[str, bytes]) -> bool:
    """Whether the files were read, to the last frame."""
    try:
        if format_name == "mcml":
            clip = read_document(io.BytesIO(files["mcml"])).clip
        else:
            sources = {part: SourceFile(f"clip.{part}", io.BytesIO(data)) for part, data in files.items()}
            clip = FORMATS[format_name].read(sources, ReadOptions(limits=LIMITS))
        found = frames(clip)
    except McmlError:
        return False
    assert clip.frames in (None, len(found))
    return True


def campaign(format_name: str, seed: int, count: int) -> None:
    chance = random.Random(f"{format_name} {seed}")
    read = 0
    for number in range(count):
        files = dict(chance.choice(FILES[format_name]))
        part = chance.choice(list(files))
        files[part] = damaged(files[part], chance)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RuntimeWarning)
                read += read_or_refuse(format_name, files)
        except Exception as error:
            raise AssertionError(f"{format_name}, seed {seed}, file {number}: {files[part][:3000]!r}") from error
    assert 0 < read < count


@pytest.mark.parametrize("format_name", FILES)
def test_damaged_files(format_name: str) -> None:
    campaign(format_name, 0, 150)


@pytest.mark.fuzz(seeds=8)
@pytest.mark.parametrize("format_name", FILES)
def test_many_damaged_files(format_name: str, seed: int) -> None:
    campaign(format_name, seed, 1000)
