"""Motion files to clips and back.

`FORMATS` is the catalogue of readers, `WRITERS` of writers. `find_format` recognises the format of a file.
"""

from __future__ import annotations

from mcml.formats.asf_amc.format import AsfAmc
from mcml.formats.bvh.format import Bvh
from mcml.formats.c3d.format import C3d
from mcml.formats.format import Format, Writer
from mcml.formats.htr.format import Htr
from mcml.formats.opensim.storage import OpenSim
from mcml.formats.recognition import UNSUPPORTED, recognise
from mcml.formats.scenes.glb import Glb
from mcml.formats.scenes.usd import Usd
from mcml.formats.trc.format import Trc

__all__ = ["FORMATS", "NEEDED", "UNSUPPORTED", "WRITERS", "find_format"]

FORMATS: dict[str, Format] = {
    "bvh": Bvh(),
    "asf-amc": AsfAmc(),
    "htr": Htr(),
    "c3d": C3d(),
    "trc": Trc(),
}
"""Every format that is read and written, by its name."""

WRITERS: dict[str, Writer] = {
    **FORMATS,
    "glb": Glb(),
    "usd": Usd("usd", "USD", (".usd", ".usdc")),
    "usda": Usd("usda", "USD as text", (".usda",)),
    "mot": OpenSim("mot", "OpenSim motion"),
    "sto": OpenSim("sto", "OpenSim storage"),
}
"""Every format that can be written, by its name: those that are read, and export formats."""

NEEDED = {"glb": "pygltflib", "usd": "pxr", "usda": "pxr"}
"""Modules that writers need and that are not always installed, by format."""


def find_format(file_name: str, first_bytes: bytes) -> tuple[Format, str]:
    """Return the (format, part) of a file, by its content first and its name second.

    first_bytes: the first 4 kB, or all of a shorter file. Raises FormatError and UnsupportedError, which name the
    actual format if it can be recognised.
    """
    return recognise(FORMATS, file_name, first_bytes)
