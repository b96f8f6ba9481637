"""Poses of SMPL models in `.npz`, in the layout of AMASS: `poses`, `trans`, the rate, `betas`, `gender`.

Source: N. Mahmood et al., "AMASS: Archive of Motion Capture as Surface Shapes" (2019), and its published files.
"""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Iterator
from typing import IO

import numpy as np

from mcml.errors import ConversionError
from mcml.formats.format import FileKind, need_seconds, note
from mcml.formats.smpl.poses import Poses, own_poses, transfer_poses
from mcml.formats.smpl.skeleton import find_body
from mcml.motion.clip import ClipHead, ClipStream
from mcml.motion.conventions.convert import with_scale_factor
from mcml.motion.rotation_vectors import to_vector
from mcml.motion.skeleton import Array

_MODELS = {22: "smpl", 24: "smpl", 52: "smplh", 55: "smplx"}
_SHAPES = {"smpl": 10, "smplh": 16, "smplx": 16}
"""Numbers of shape in files of each model."""
_BLOCK = 1 << 20
_LONGEST_SHAPE = 400


class SmplWriter:
    """The format `smpl`; see `mcml.formats.format.Writer`."""

    name = "smpl"
    title = "SMPL and AMASS poses"
    label = "SMPL"
    parts = (FileKind("npz", (".npz",), "Poses of a body model"),)
    convention = None
    media_type = "application/octet-stream"
    bodies, markers = True, False
    needs = frozenset({"frame_time"})
    assumes = "m"

    def write(self, clip: ClipStream, part: str) -> Iterator[bytes]:
        clip = with_scale_factor(clip)
        seconds = need_seconds(clip.head, "AMASS")
        body = find_body(clip.head.skeleton)
        poses = transfer_poses(clip, seconds) if body is None else own_poses(clip, body)
        gender, betas = _read_shape(clip.head) if body is not None else ("neutral", None)
        return _write(poses, clip, 1 / seconds, gender, betas)


def _read_shape(head: ClipHead) -> tuple[str, Array | None]:
    """The properties `gender` and `betas` as the reader makes them; None without betas, or with other texts."""
    texts = {name: value for name, value, _ in head.properties}
    try:
        betas = np.array([float(text) for text in texts.get("betas", "").split()[:_LONGEST_SHAPE]])
    except ValueError:
        betas = np.empty(0)
    return texts.get("gender", "neutral")[:100], betas if len(betas) and np.isfinite(betas).all() else None


def _write(poses: Poses, clip: ClipStream, rate: float, gender: str, betas: Array | None) -> Iterator[bytes]:
    model = _MODELS[len(poses.body.names)]
    if betas is None:
        betas = np.zeros(_SHAPES[model])
        note(clip.notices, "note", "the file states the mean shape: `betas` are zeros")
    facts = {
        "gender": np.array(gender), "betas": betas, "surface_model_type": np.array(model),
    }  # fmt: skip
    # AMASS names the rate in two ways, and readers take either for Z up.
    names = ("mocap_framerate", "mocap_frame_rate") if poses.is_z_up else ("fps",)
    facts |= dict.fromkeys(names, np.array(rate))
    with tempfile.TemporaryFile(prefix="mcml-npz-") as numbers, tempfile.TemporaryFile(prefix="mcml-npz-") as target:
        places = _write_rows(poses, numbers)
        if not len(places):
            raise ConversionError("AMASS files have frames, and the clip has none", remedy="Export it as MCML or HTR.")
        with zipfile.ZipFile(target, "w") as archive:
            with archive.open(_entry("poses"), "w", force_zip64=True) as member:
                shape = (len(places), 3 * len(poses.body.names))
                header = {"descr": "<f8", "fortran_order": False, "shape": shape}
                np.lib.format.write_array_header_1_0(member, header)
                numbers.seek(0)
                while block := numbers.read(_BLOCK):
                    member.write(block)
            for name, values in {"trans": places, **facts}.items():
                with archive.open(_entry(name), "w", force_zip64=True) as member:
                    np.lib.format.write_array(member, values, allow_pickle=False)
        target.seek(0)
        while block := target.read(_BLOCK):
            yield block


def _write_rows(poses: Poses, numbers: IO[bytes]) -> Array:
    """Write the axis-angles of all frames; return `trans` (n, 3)."""
    count = len(poses.body.names)
    all_places = [np.empty((0, 3))]
    for places, rotations in poses.blocks():
        vectors = np.empty((len(places), count, 3))
        vectors[:, poses.body.places] = to_vector(rotations)
        numbers.write(np.ascontiguousarray(vectors, "<f8").tobytes())
        # The root of the models rests at an offset; `trans` starts there.
        all_places.append(places - np.array(poses.body.offsets[0]))
    return np.concatenate(all_places)


def _entry(name: str) -> zipfile.ZipInfo:
    """Times are fixed, so that equal clips give equal bytes."""
    return zipfile.ZipInfo(f"{name}.npy", (1980, 1, 1, 0, 0, 0))
