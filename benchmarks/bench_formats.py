"""Reading BVH to arrays against pybvh, a bare simdjson parse and numpy; writing it against numpy.savetxt.

One large file in four spellings: as MotionBuilder and its like write it, with doubled and trailing blanks, with
exponents and integers without sign of zero, and as real files of many programs one after the other.
"""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import orjson
import pybvh
import simdjson

from benchmarks.timing import median_seconds, report
from mcml.formats import FORMATS
from mcml.formats.format import ReadOptions, SourceFile
from mcml.formats.text.number_text import rows_of_text
from mcml.motion.clip import ClipStream

MEGABYTES = 50
REPEAT = 3


def _parsed(array: bytes) -> object:
    """The numbers of a JSON array, by simdjson alone."""
    numbers: Any = simdjson.Parser().parse(array)
    return np.frombuffer(numbers.as_buffer(of_type="d"))


def _written(clip: ClipStream) -> int:
    return sum(map(len, FORMATS["bvh"].write(clip, "bvh")))


def run() -> dict[str, object]:
    figures: dict[str, object] = {}
    table = _motion()
    spellings: dict[str, Callable[[], str]] = {
        "fixed": lambda: _fixed(table, " ", ""),
        "blanks": lambda: _fixed(table, "  ", " "),
        "exponents": lambda: _general(table),
    }
    with tempfile.TemporaryDirectory() as folder:
        for name, spelling in spellings.items():
            path = Path(folder) / f"{name}.bvh"
            path.write_text(_file(table.shape[1], spelling(), len(table)))
            figures[name] = _measure_reading(path, name)
        figures["many"] = _measure_many()
        figures["writing"] = _measure_writing(Path(folder) / "fixed.bvh")
    return figures


def _motion() -> np.ndarray:
    """(n, 183) channels of a figure with fingers: smooth angles, some joints that never move."""
    rng = np.random.default_rng(1)
    frames, channels = MEGABYTES * 1_000_000 // (183 * 9), 183
    table = np.cumsum(rng.normal(0, 0.3, (frames, channels)), axis=0)
    table[:, rng.random(channels) < 0.2] = 0.0
    rounded: np.ndarray = np.round(table % 360 - 180 * (table != 0), 4)
    return rounded


def _file(channels: int, motion: str, frames: int) -> str:
    joints = (channels - 3) // 3
    names = [f"Joint{index}" for index in range(joints)]
    lines = ["HIERARCHY", f"ROOT {names[0]}", "{", "OFFSET 0 0 0"]
    lines.append("CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation")
    for name in names[1:]:
        lines += [f"JOINT {name}", "{", "OFFSET 0 5 0", "CHANNELS 3 Zrotation Xrotation Yrotation"]
        lines += ["End Site", "{", "OFFSET 0 1 0", "}", "}"]
    lines += ["}", "MOTION", f"Frames: {frames}", "Frame Time: 0.01", motion]
    return "\n".join(lines)


def _fixed(table: np.ndarray, between: str, at_end: str) -> str:
    rows = rows_of_text(table, "fixed:4")
    return "\n".join(row.decode().replace(" ", between) + at_end for row in rows) + "\n"


def _general(table: np.ndarray) -> str:
    small = table * 10.0 ** np.random.default_rng(2).integers(-8, 2, table.shape)
    small[:, ::7] = -0.0
    line = " ".join(["%.6g"] * table.shape[1])
    return "\n".join(line % tuple(row) for row in small.tolist()) + "\n"


def _read(path: Path) -> int:
    with path.open("rb") as stream:
        clip = FORMATS["bvh"].read({"bvh": SourceFile(path.name, stream)}, ReadOptions())
        return sum(block.values.size for block in clip.blocks())


def _measure_reading(path: Path, name: str) -> dict[str, float]:
    size = path.stat().st_size / 1e6
    text = path.read_bytes()
    motion = text[text.index(b"\n", text.index(b"Frame Time")) :]
    ours = median_seconds(lambda: _read(path), REPEAT)
    peer = median_seconds(lambda: pybvh.read_bvh_file(str(path), world_up="+y"), REPEAT)
    array = b"[" + b",".join(motion.split()) + b"]"
    bare = median_seconds(lambda: _parsed(array), REPEAT)
    plain = median_seconds(lambda: np.array(motion.split(), dtype=np.float64), 1)
    report(f"reading {name}, {size:.0f} MB: MB/s", size / ours)
    report("   bare simdjson parse of the numbers: MB/s", len(array) / 1e6 / bare)
    return {
        "megabytes_per_second": size / ours,
        "pybvh": report("   pybvh takes so many times longer", peer / ours, ">= 1.5"),
        "numpy_split": report("   numpy.array(text.split()) takes so many times longer", plain / ours),
        "bare_parse": report("   as many times the bare parse", ours / bare),
    }


def _measure_many() -> dict[str, float]:
    """The real files beside the repository, as often as it takes."""
    stated = os.environ.get("MCML_SHARED")
    folder = (Path(stated) if stated else Path(__file__).resolve().parents[2] / "shared") / "data" / "bvh"
    # pybvh refuses files whose joints move in their parents: they are left out for both.
    paths = [path for path in sorted(folder.rglob("*.bvh")) if "malformed" not in path.parts and _is_read(path)]
    if not paths:
        print("   the real files are not here")
        return {}
    size = sum(path.stat().st_size for path in paths) / 1e6
    ours = median_seconds(lambda: [_read(path) for path in paths], REPEAT)
    peer = median_seconds(lambda: [pybvh.read_bvh_file(str(path), world_up="+y") for path in paths], REPEAT)
    report(f"reading {len(paths)} real files, {size:.0f} MB: MB/s", size / ours)
    return {"pybvh": report("   pybvh takes so many times longer", peer / ours, ">= 1.5")}


def _is_read(path: Path) -> bool:
    try:
        pybvh.read_bvh_file(str(path), world_up="+y")
    except ValueError:
        return False
    return True


def _measure_writing(path: Path) -> dict[str, float]:
    with path.open("rb") as stream:
        clip = FORMATS["bvh"].read({"bvh": SourceFile(path.name, stream)}, ReadOptions())
        blocks = list(clip.blocks())
    values = np.concatenate([block.values for block in blocks])
    held = ClipStream(clip.head, lambda: iter(blocks), clip.frames)
    figures: dict[str, float] = {}
    peer = median_seconds(lambda: np.savetxt(io.BytesIO(), values, fmt="%.17g"), 1)
    bare = median_seconds(lambda: orjson.dumps(values, option=orjson.OPT_SERIALIZE_NUMPY), REPEAT)
    fixed_peer = median_seconds(lambda: np.savetxt(io.BytesIO(), values, fmt="%.4f"), 1)
    for style, other in (("shortest", peer), ("fixed:4", fixed_peer)):
        styled = held.with_head(replace(held.head, number_style=style))
        size = sum(map(len, FORMATS["bvh"].write(styled, "bvh"))) / 1e6
        ours = median_seconds(partial(_written, styled), REPEAT)
        report(f"writing {style}, {size:.0f} MB: MB/s", size / ours)
        target = ">= 4" if style == "shortest" else ""
        figures[style] = report("   numpy.savetxt takes so many times longer", other / ours, target)
        if style == "shortest":
            figures["bare_orjson"] = report("   as many times a bare orjson.dumps", ours / bare)
    return figures
