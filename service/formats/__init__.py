"""Motion files to clips and back. `FORMATS` is the catalogue; `find_format` tells what a file is."""

from __future__ import annotations

from service.formats.asf_amc import AsfAmc
from service.formats.bvh import Bvh
from service.formats.c3d import C3d
from service.formats.format import Format
from service.formats.htr import Htr
from service.formats.recognition import UNSUPPORTED, recognise
from service.formats.trc import Trc

__all__ = ["FORMATS", "UNSUPPORTED", "find_format"]

FORMATS: dict[str, Format] = {
    "bvh": Bvh(),
    "asf-amc": AsfAmc(),
    "htr": Htr(),
    "c3d": C3d(),
    "trc": Trc(),
}
"""Every format that is read and written, by its name."""


def find_format(file_name: str, first_bytes: bytes) -> tuple[Format, str]:
    """(format, part) of a file, by its content first and its name second.

    first_bytes: the first 4 kB, or all of a shorter file. Raises FormatError and UnsupportedError, which say what the
    file is instead, as far as that can be told.
    """
    return recognise(FORMATS, file_name, first_bytes)
