"""Motion files to clips and back: `READERS` is the catalogue of formats that are read, `WRITERS` of those written.

`FORMATS` is the catalogue of readers, `WRITERS` of writers. `find_format` recognises the format of a file.
"""

from __future__ import annotations

from mcml.formats.arkit.format import Arkit
from mcml.formats.arkit.writer import ArkitWriter
from mcml.formats.asf_amc.format import AsfAmc
from mcml.formats.bvh.format import Bvh
from mcml.formats.c3d.format import C3d
from mcml.formats.fbx.format import Fbx
from mcml.formats.format import Format, Reader, Writer
from mcml.formats.gltf.format import Gltf
from mcml.formats.htr.format import Htr
from mcml.formats.mvnx.format import Mvnx
from mcml.formats.opensim.storage import OpenSim
from mcml.formats.opensim.trial import OpenSimTrial
from mcml.formats.recognition import UNSUPPORTED, recognise
from mcml.formats.scenes.glb import Glb
from mcml.formats.scenes.usd import Usd
from mcml.formats.scenes.vrma import Vrma
from mcml.formats.smpl.format import Smpl
from mcml.formats.smpl.writer import SmplWriter
from mcml.formats.trc.format import Trc
from mcml.formats.usd.format import UsdReader

__all__ = ["FORMATS", "NEEDED", "READERS", "SHAPED", "SKINNED", "UNSUPPORTED", "WRITERS", "find_format"]

FORMATS: dict[str, Format] = {
    "bvh": Bvh(),
    "asf-amc": AsfAmc(),
    "htr": Htr(),
    "c3d": C3d(),
    "trc": Trc(),
}
"""Every format that is read and written, by its name."""

READERS: dict[str, Reader] = {
    **FORMATS,
    "fbx": Fbx(),
    "glb": Gltf(),
    "usd": UsdReader(),
    "smpl": Smpl(),
    "mvnx": Mvnx(),
    "arkit": Arkit(),
}
"""Every format that is read, by its name."""

WRITERS: dict[str, Writer] = {
    **FORMATS,
    "glb": Glb(),
    "vrma": Vrma(),
    "usd": Usd("usd", "USD", (".usd", ".usdc")),
    "usda": Usd("usda", "USD as text", (".usda",)),
    "mot": OpenSim("mot", "OpenSim motion"),
    "sto": OpenSim("sto", "OpenSim storage"),
    "opensim": OpenSimTrial(),
    "smpl": SmplWriter(),
    "arkit": ArkitWriter(),
}
"""Every format that is written, by its name."""

SKINNED = frozenset({"glb", "usd", "usda"})
"""Formats that can hold a body with a skin."""

SHAPED = frozenset({"glb", "arkit"})
"""Formats that can hold weights of blend shapes, besides MCML and CSV."""

NEEDED = {"glb": "pygltflib", "vrma": "pygltflib", "usd": "pxr", "usda": "pxr"}
"""Modules that formats need and that are not always installed, by format."""


def find_format(file_name: str, first_bytes: bytes) -> tuple[Reader, str]:
    """(format, part) of a file, by its content first and its name second.

    first_bytes: the first 4 kB, or all of a shorter file. Raises FormatError and UnsupportedError, which name the
    actual format if it can be recognised.
    """
    return recognise(READERS, file_name, first_bytes)
