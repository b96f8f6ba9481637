"""OpenSim's tables of angles over time: MOT and STO. A head of lines `key=value`, then rows with tabs between.

Columns are angles of the body as in queries (docs/formats/opensim.md), not coordinates of one model.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from mcml.errors import ConversionError
from mcml.formats.format import FileKind, need_seconds, note
from mcml.formats.text.number_text import SHORTEST, rows_of_text
from mcml.motion.clip import ClipHead, ClipStream
from mcml.motion.skeleton import Convention

if TYPE_CHECKING:
    from mcml.formats.opensim.angles import BodyAngles

_UNFIT = re.compile("[\x00-\x1f\x7f-\x9f=\u2028\u2029]")
_HEADS = {"mot": ("version=1",), "sto": ("DataType=double", "version=3")}


class OpenSim:
    """The formats `mot` and `sto`; see `mcml.formats.format.Writer`."""

    convention = None
    media_type = "text/plain"
    bodies, markers = True, False
    needs = frozenset({"frame_time"})
    assumes = ""

    def __init__(self, name: str, title: str) -> None:
        self.name = name
        self.title = title
        self.label = f"OpenSim {name.upper()}"
        self.parts = (FileKind(name, (f".{name}",), "Angles of the body"),)

    def write(self, clip: ClipStream, part: str) -> Iterator[bytes]:
        if any(joint.convention is Convention.MARKER for joint in clip.head.skeleton.joints):
            raise ConversionError("markers have no angles", remedy="Export them as TRC, which OpenSim reads.")
        seconds = need_seconds(clip.head, part.upper())
        from mcml.formats.opensim.angles import BodyAngles

        angles = BodyAngles(clip)
        if not np.isfinite(angles.frames * seconds):
            raise ConversionError(
                f"the times of the frames are beyond the largest number, at {seconds:g} seconds each",
                remedy="State another frame time first.",
            )
        return _write(clip, angles, part, seconds)


def _write(clip: ClipStream, angles: BodyAngles, part: str, seconds: float) -> Iterator[bytes]:
    lines = [
        _name(clip.head),
        *_HEADS[part],
        f"nRows={angles.frames}",
        f"nColumns={len(angles.columns) + 1}",
        "inDegrees=yes",
        "endheader",
        "\t".join(["time", *(column.title for column in angles.columns)]),
    ]
    yield ("\n".join(lines) + "\n").encode("utf-8", "replace")
    done = gaps = 0
    for degrees in angles.blocks():
        times = np.arange(done, done + len(degrees), dtype=np.float64) * seconds
        values = np.column_stack([times, degrees])
        missing = np.isnan(values)
        rows = rows_of_text(np.where(missing, 0.0, values), SHORTEST, "\t")
        for row in np.flatnonzero(missing.any(axis=1)).tolist():
            cells = rows[row].split(b"\t")
            rows[row] = b"\t".join(b"nan" if gone else cell for cell, gone in zip(cells, missing[row], strict=True))
        gaps += int(missing.sum())
        done += len(degrees)
        yield b"\n".join([*rows, b""])
    if gaps:
        note(
            clip.notices,
            "note",
            f"{gaps} angles are unknown and written as nan: a sample is missing, or a limb is parallel to its axis",
        )


def _name(head: ClipHead) -> str:
    """The first line: a word that no reader takes for a key or for the end of the head."""
    said = _UNFIT.sub("_", head.fields.get("filename", "").rsplit("/", 1)[-1]).strip()
    return said if said and said.lower() != "endheader" else "motion"
