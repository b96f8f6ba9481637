"""USD: usda, usdc, usd and usdz with skeletons of UsdSkel.

Source: OpenUSD, "UsdSkel Schemas", https://openusd.org. usd-core reads and evaluates the file in a process of its own.
docs/formats/usd.md describes the reading.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.util import find_spec

from mcml.errors import UnsupportedError
from mcml.formats.format import FileKind, ReadOptions, SourceFile
from mcml.formats.scenes.apart import list_takes_apart, read_apart
from mcml.formats.scenes.reader import SceneReader
from mcml.formats.scenes.scene import Scene
from mcml.formats.zip_entries import first_entry

_LAYERS = (".usd", ".usda", ".usdc")


class UsdReader(SceneReader):
    """The format `usd` as it is read; see `mcml.formats.format.Reader`."""

    name = "usd"
    title = "USD"
    label = "USD"
    parts = (FileKind("usd", (".usd", ".usda", ".usdc", ".usdz"), "Skeletons and motions"),)
    media_type = "model/vnd.usd"

    def sniff(self, name: str, first_bytes: bytes) -> str | None:
        entry = first_entry(first_bytes)
        if entry is not None:
            return "usd" if entry.stored and entry.name.lower().endswith(_LAYERS) else None
        return "usd" if first_bytes.startswith((b"PXR-USDC", b"#usda ")) else None

    def open_scene(self, files: Mapping[str, SourceFile], options: ReadOptions) -> Scene:
        _need_library()
        return read_apart("mcml.processes.evaluate_usd", files["usd"], options)

    def list_takes(self, files: Mapping[str, SourceFile], options: ReadOptions) -> list[str]:
        _need_library()
        return list_takes_apart("mcml.processes.evaluate_usd", files["usd"], options)


def _need_library() -> None:
    if find_spec("pxr") is None:
        raise UnsupportedError(
            "USD needs a library that is not installed.",
            remedy="Install the extra: pip install 'mcml-repository[usd]'.",
        )
