"""Files of every format that is read, of any length, with gaps, warnings, repairs and faults at their end.

What a reader does for a message, or for a frame that is not like the others, must not grow with what stands before it.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from mcml.errors import McmlError
from mcml.formats import FORMATS
from mcml.formats.format import ReadOptions, SourceFile
from mcml.formats.repairs import offers, repaired
from mcml.language.reader import read_document

BODY = """HIERARCHY
ROOT Hips
{
OFFSET 0 90 0
CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
JOINT Knee
{
OFFSET 0 -45 0
CHANNELS 3 Zrotation Xrotation Yrotation
End Site
{
OFFSET 0 -45 0
}
}
}
MOTION
"""
ASF = """:version 1.10
:units
  mass 1.0
  length 0.45
  angle deg
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
  begin
    id 1
    name thigh
    direction 0 -1 0
    length 7
    axis 0 0 0 XYZ
    dof rx ry rz
    limits (-160 20) (-70 70) (-60 70)
  end
:hierarchy
  begin
    root thigh
  end
"""
HTR = """[Header]
FileType htr
DataType HTRS
FileVersion %d
NumSegments 2
NumFrames %d
DataFrameRate 30
EulerRotationOrder ZYX
CalibrationUnits mm
RotationUnits Degrees
GlobalAxisofGravity Y
BoneLengthAxis Y
ScaleFactor 1
[SegmentNames&Hierarchy]
Hips GLOBAL
Knee Hips
[BasePosition]
Hips 0 0 0 0 0 0 10
Knee 0 -10 0 0 0 0 10
"""
TRC = (
    "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n100\t100\t%d\t2\tmm\n"
    "Frame#\tTime\tA\t\t\tB\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"
)


@dataclass(frozen=True)
class Input:
    """Files of one clip, by part. format: catalogue name, or "mcml"."""

    format: str
    files: dict[str, bytes]


def bvh(frames: int, fault: str = "") -> Input:
    """Whole numbers and exponents in turn, so that no block is plain. fault: what stands behind the last frame."""
    rows = "".join(f"1 {row % 7} .5 -0 1e-3 {row} 0 0 1\n" for row in range(frames))
    return Input("bvh", {"bvh": f"{BODY}Frames: {frames + bool(fault)}\nFrame Time: 0.01\n{rows}{fault}".encode()})


def bvh_of_one_line(joints: int) -> Input:
    """A hierarchy without a line end: readers that look at the rest of a line must not look at all of it."""
    joint = "JOINT a { OFFSET 1 2 3 CHANNELS 3 Zrotation Xrotation Yrotation End Site { OFFSET 0 1 0 } } "
    head = f"HIERARCHY ROOT r {{ OFFSET 0 0 0 CHANNELS 3 Zrotation Xrotation Yrotation {joint * joints} }} MOTION "
    return Input("bvh", {"bvh": f"{head}Frames: 1\nFrame Time: 1\n{'0 ' * (3 * joints + 3)}\n".encode()})


def amc(frames: int, fault: str = "") -> Input:
    """Every second frame without the thigh, so that each is a frame of its own shape; a comment in every one."""
    thigh = ("thigh 1 2 3\n", "")
    rows = "".join(f"{row + 1} # {row}\nroot 0 1 2 3 4 {row}\n{thigh[row % 2]}" for row in range(frames))
    return Input("asf-amc", {"asf": ASF.encode(), "amc": f":FULLY-SPECIFIED\n:DEGREES\n{rows}{fault}".encode()})


def htr(frames: int, fault: str = "") -> Input:
    """Samples that are missing, and a second segment that numbers its frames otherwise than the first."""
    missing = " ".join(["9999999"] * 7)

    def rows(first: int) -> str:
        return "".join(f"{row + first} {missing if row % 3 else '0 1 2 3 4 5 1'}\n" for row in range(frames))

    text = f"{HTR % (1, frames)}[Hips]\n{rows(1)}[Knee]\n{rows(2)}{fault}[EndOfFile]\n"
    return Input("htr", {"htr": text.encode()})


def htr2(frames: int, fault: str = "") -> Input:
    """Frame by frame, with samples that are missing and a comment in every frame."""
    missing = " ".join(["9999999"] * 7)
    rows = "".join(
        f"Frame {row + 1}: # {row}\nHips 0 1 2 3 4 5 1\nKnee {missing if row % 3 else '0 0 0 1 2 3 1'}\n"
        for row in range(frames)
    )
    return Input("htr", {"htr": f"{HTR % (2, frames)}{rows}{fault}[EndOfFile]\n".encode()})


def trc(frames: int, fault: str = "") -> Input:
    """A cell that is empty in every row but each third one, and times that do not follow from the rate."""
    cells = ("1.5\t2.5\t", "1.5\t\t", "\t\t")
    rows = "".join(f"{row + 1}\t{row * row * 1e-4:.4f}\t{cells[row % 3]}3\t4\t5\t6\n" for row in range(frames))
    return Input("trc", {"trc": f"{TRC % frames}{rows}{fault}".encode()})


def c3d(frames: int, fault: str = "") -> Input:
    """Two points that come and go. fault: anything; the bytes of half a frame are lacking."""
    gone = struct.pack("<ffff", 0, 0, 0, -1)
    data = b"".join(
        (struct.pack("<ffff", row, 2, 3, 1) if row % 3 else gone)
        + (struct.pack("<ffff", 1, 2, 3, 0) if row % 4 else gone)
        for row in range(frames)
    )
    data = data[:-16] if fault else data
    header = struct.pack("<BBHHHHHfHHf", 2, 0x50, 2, 0, 1, min(frames, 0xFFFF), 0, -1.0, 3, 0, 100.0)
    parameters = b"\1\x50\1\x54" + _group(1, b"POINT") + _float(1, b"LONG_FRAMES", frames) + _float(1, b"RATE", 100)
    return Input("c3d", {"c3d": header.ljust(512, b"\0") + parameters.ljust(512, b"\0") + data})


def _group(number: int, name: bytes) -> bytes:
    return struct.pack("<bb", len(name), -number) + name + struct.pack("<HB", 3, 0)


def _float(group: int, name: bytes, value: float) -> bytes:
    return struct.pack("<bb", len(name), group) + name + struct.pack("<HbBfB", 9, 4, 0, value, 0)


def mcml(frames: int, fault: str = "") -> Input:
    """A sample that comes and goes, a comment within a motion name, and a description that comments cut to pieces."""
    y = ' Ty="2"'
    rows = "".join(
        f'<frame id="{row + 1}"><motion_name>a<!-- b -->c</motion_name>'
        f'<frame_bone name="Root" Tx="1"{y if row % 3 else ""}/></frame>\n'
        for row in range(frames)
    )
    words = "a<!-- b -->" * frames
    text = (
        f'<mcml version="1.1"><header><description>{words}</description></header><root order="Tx Ty Tz"/><skeleton/>'
        f"<motion><frames>{frames}</frames><frametime>0.01</frametime>{rows}{fault}</motion></mcml>"
    )
    return Input("mcml", {"mcml": text.encode()})


def mcml_of_one_name(pieces: int) -> Input:
    """A motion name that comments cut into many pieces."""
    name = "a<!-- -->" * pieces
    text = (
        '<mcml version="1.1"><header/><root order="Tx"/><skeleton/><motion><frames>1</frames><frametime>1</frametime>'
        f'<frame id="1"><motion_name>{name}</motion_name><frame_bone name="Root" Tx="1"/></frame></motion></mcml>'
    )
    return Input("mcml", {"mcml": text.encode()})


INPUTS: dict[str, Callable[[int], Input]] = {
    "bvh": bvh,
    "bvh that is cut off": lambda frames: bvh(frames, "1 2 3"),
    "bvh with a bad number": lambda frames: bvh(frames, "1 2 x 4 5 6 7 8 9\n"),
    "bvh with touching numbers": lambda frames: bvh(frames, "1 2-3 4 5 6 7 8 9\n"),
    "bvh of one line": lambda frames: bvh_of_one_line(frames // 8 + 1),
    "amc": amc,
    "amc with a bad number": lambda frames: amc(frames, "99999\nroot 1 2 3 4 5 x\n"),
    "amc that is cut off": lambda frames: amc(frames, "99999\nroot 1 2"),
    "htr": htr,
    "htr with a bad number": lambda frames: htr(frames, "7 0 0 0 x 0 0 1\n"),
    "htr 2": htr2,
    "htr 2 with a bad number": lambda frames: htr2(frames, "Frame 7\nHips 0 0 0 x 0 0 1\n"),
    "trc": trc,
    "trc with a bad number": lambda frames: trc(frames, "7\t1\tx\t1\t1\t1\t1\t1\n"),
    "c3d": c3d,
    "c3d that is cut off": lambda frames: c3d(frames, "cut"),
    "mcml": mcml,
    "mcml with a bad number": lambda frames: mcml(frames, '<frame id="9"><frame_bone name="Root" Tx="x"/></frame>'),
    "mcml of one name": mcml_of_one_name,
}
"""Inputs by what is odd in them, each for a number of frames."""

OpenFile = Callable[[bytes], io.BytesIO]


def read_through(made: Input, opened: OpenFile = io.BytesIO) -> int:
    """Read a clip to its end or its fault, repair it where that is offered. Return the frames that were read."""
    frames = 0
    files = {part: SourceFile(f"a.{part}", opened(data)) for part, data in made.files.items()}
    try:
        if made.format == "mcml":
            clip = read_document(files["mcml"].stream).clip
        else:
            clip = FORMATS[made.format].read(files, ReadOptions())
        for block in clip.blocks():
            frames += len(block)
    except McmlError:
        mended, _ = repaired(files, tuple(offers(files)))
        with suppress(McmlError):
            if made.format != "mcml":
                frames = sum(map(len, FORMATS[made.format].read(mended, ReadOptions()).blocks()))
    return frames
