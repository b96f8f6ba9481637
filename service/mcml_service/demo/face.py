"""A generated face: brows, lids, cheeks, lips and jaw as translating segments of an HTR clip (millimetres)."""

from __future__ import annotations

import numpy as np

RATE = 60

_POINTS = {
    "brow_in_l": (14, 62, 92), "brow_in_r": (-14, 62, 92), "brow_out_l": (44, 64, 78), "brow_out_r": (-44, 64, 78),
    "lid_up_l": (31, 44, 84), "lid_up_r": (-31, 44, 84), "cheek_l": (44, 8, 76), "cheek_r": (-44, 8, 76),
    "lip_up": (0, -22, 104), "lip_low": (0, -38, 100), "mouth_l": (26, -30, 90), "mouth_r": (-26, -30, 90),
    "jaw": (0, -66, 88),
}  # fmt: skip
_EXPRESSIONS: dict[str, dict[str, tuple[float, float, float]]] = {
    "smile": {"mouth": (7, 8, -4), "cheek": (3, 6, 2), "lip_low": (0, -2, -1)},
    "surprise": {"brow_in": (0, 9, 0), "brow_out": (0, 8, 0), "lid_up": (0, 3, 0), "jaw": (0, -16, -4),
                 "lip_low": (0, -12, -2)},
    "anger": {"brow_in": (-3, -7, 1), "brow_out": (0, -3, 0), "mouth": (-2, -3, 0), "lip_up": (0, -1, 1)},
}  # fmt: skip


def face_htr(seed: int, seconds_each: float = 1.6) -> tuple[bytes, list[tuple[str, int, int]]]:
    """(HTR text, labels (name, first, last)) of a take that goes through every expression once."""
    rng = np.random.default_rng(seed)
    length = round(seconds_each * RATE)
    bump = np.sin(np.linspace(0, np.pi, length)) ** 2
    frames = length * len(_EXPRESSIONS)
    labels = []
    moved = {name: rng.normal(0, 0.05, (frames, 3)) for name in _POINTS}
    for number, (expression, shifts) in enumerate(_EXPRESSIONS.items()):
        start = number * length
        labels.append((expression, start + 1, start + length))
        strength = rng.uniform(0.8, 1.2)
        for name in _POINTS:
            shift = next((s for part, s in shifts.items() if name.startswith(part)), None)
            if shift is not None:
                mirrored = np.array(shift) * ((-1 if name.endswith("_r") else 1), 1, 1)
                moved[name][start : start + length] += strength * bump[:, None] * mirrored
    lines = [
        "# generated face", "[Header]", "FileType htr", "DataType HTRS", "FileVersion 1",
        f"NumSegments {len(_POINTS) + 1}", f"NumFrames {frames}", f"DataFrameRate {RATE}", "EulerRotationOrder ZYX",
        "CalibrationUnits mm", "RotationUnits Degrees", "GlobalAxisofGravity Y", "BoneLengthAxis Y", "ScaleFactor 1.00",
        "[SegmentNames&Hierarchy]", "head\tGLOBAL", *(f"{name}\thead" for name in _POINTS),
        "[BasePosition]", "head\t0.0\t1600.0\t0.0\t0.0\t0.0\t0.0\t120.0",
        *(f"{name}\t{x}.0\t{y}.0\t{z}.0\t0.0\t0.0\t0.0\t5.0" for name, (x, y, z) in _POINTS.items()),
    ]  # fmt: skip
    nod = 4 * np.sin(np.linspace(0, 4 * np.pi, frames))
    lines.append("[head]")
    lines += [f"{i + 1}\t0.000\t0.000\t0.000\t{angle:.3f}\t0.000\t0.000\t1.0" for i, angle in enumerate(nod)]
    for name in _POINTS:
        lines.append(f"[{name}]")
        lines += [
            f"{i + 1}\t{x:.3f}\t{y:.3f}\t{z:.3f}\t0.000\t0.000\t0.000\t1.0" for i, (x, y, z) in enumerate(moved[name])
        ]
    lines.append("[EndOfFile]")
    return ("\n".join(lines) + "\n").encode(), labels
