"""Animations of glTF: keys, their rate, and values between them.

Source: glTF 2.0 specification, section 3.11 and appendix C (interpolation), Khronos Group 2021.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml.errors import FormatError
from mcml.formats.gltf.document import DAMAGED, Document, as_number
from mcml.motion.rotations import slerp
from mcml.motion.skeleton import Array

WIDTH = {"translation": 3, "rotation": 4, "scale": 3}
_MODES = ("LINEAR", "STEP", "CUBICSPLINE")
_USUAL = (23.976, 24.0, 25.0, 29.97, 30.0, 48.0, 50.0, 59.94, 60.0, 90.0, 100.0, 119.88, 120.0, 240.0)
DEFAULT_RATE, LEAST_RATE = 30.0, 10.0
_NEAR = 0.01
"""Part of a frame by which a key may be beside it."""


@dataclass(frozen=True, eq=False)
class Track:
    """The keys of one property of a node.

    path: "translation", "rotation", "scale" or "weights" of the morph targets of its mesh. times: (k,) seconds. values:
    (k, width), or (k, 3, width) with tangents around each value for CUBICSPLINE.
    """

    node: int
    path: str
    mode: str
    times: Array
    values: Array

    def sample(self, times: Array) -> Array:
        """(n, width) the values at times (n,), clamped to the first and the last key."""
        keys = self.times
        times = np.clip(times, keys[0], keys[-1])
        left = np.clip(np.searchsorted(keys, times, "right") - 1, 0, max(0, len(keys) - 2))
        right = np.minimum(left + 1, len(keys) - 1)
        length = keys[right] - keys[left]
        share = np.where(length > 0, (times - keys[left]) / np.where(length > 0, length, 1.0), 0.0)
        if self.mode == "STEP":
            # Keys are in single precision, which may put them behind the frame that they are meant for.
            reached = keys[right] - times <= np.spacing(np.abs(keys[right]).astype(np.float32))
            return np.asarray(self.values[np.where(reached, right, left)])
        if self.mode == "CUBICSPLINE":
            return self._spline(left, right, share, length)
        first, second = self.values[left], self.values[right]
        if self.path == "rotation":
            return slerp(_unit(first), _unit(second), share)
        return np.asarray(first + share[:, None] * (second - first))

    def _spline(self, left: NDArray[np.intp], right: NDArray[np.intp], share: Array, length: Array) -> Array:
        u, d = share[:, None], length[:, None]
        start, end = self.values[left], self.values[right]
        found = (
            (2 * u**3 - 3 * u**2 + 1) * start[:, 1]
            + (u**3 - 2 * u**2 + u) * d * start[:, 2]
            + (3 * u**2 - 2 * u**3) * end[:, 1]
            + (u**3 - u**2) * d * end[:, 0]
        )
        return _unit(found) if self.path == "rotation" else np.asarray(found)


def _unit(values: Array) -> Array:
    """Quaternions of length 1; NaN where there is none."""
    length = np.linalg.norm(values, axis=-1, keepdims=True)
    return np.asarray(np.where(length > 0, values / np.where(length > 0, length, 1.0), np.nan))


def read_tracks(
    document: Document, animation: dict[str, Any], nodes: int, targets: Mapping[int, int]
) -> tuple[list[Track], list[str]]:
    """The tracks of an animation, and notices. FormatError for damaged ones.

    targets: number of morph targets of each node that has some.
    """
    samplers, channels = animation.get("samplers", []), animation.get("channels", [])
    if not isinstance(samplers, list) or not isinstance(channels, list):
        raise FormatError("an animation has no samplers or channels", remedy=DAMAGED)
    found: dict[tuple[int, str], Track] = {}
    notices: list[str] = []
    for channel in channels:
        target = channel.get("target") if isinstance(channel, dict) else None
        path = target.get("path") if isinstance(target, dict) else None
        if not isinstance(target, dict) or path not in (*WIDTH, "weights") or "node" not in target:
            continue
        node, place = as_number(target["node"], "node"), as_number(channel.get("sampler"), "sampler")
        if node >= nodes or place >= len(samplers) or not isinstance(samplers[place], dict):
            raise FormatError(f"an animation names node {node} or sampler {place}, which there is not", remedy=DAMAGED)
        if path == "weights" and node not in targets:
            notices.append(f"node {node} has weights and no morph targets: they are left out")
            continue
        if (node, path) in found:
            notices.append(f"two tracks have the {path} of node {node}: the last one is read")
        found[node, path] = _read_track(document, samplers[place], node, path, WIDTH.get(path, targets.get(node, 1)))
    return list(found.values()), notices


def _read_track(document: Document, sampler: dict[str, Any], node: int, path: str, width: int) -> Track:
    mode = sampler.get("interpolation", "LINEAR")
    if mode not in _MODES:
        raise FormatError(f"interpolation {str(mode)[:40]!r} is not of glTF", remedy=DAMAGED)
    times = document.read(sampler.get("input"), 1)[:, 0]
    if path == "weights":
        # A key has a number for each target, each in an element of its own.
        values = document.read(sampler.get("output"), 1)
        values = values[: len(values) // width * width].reshape(-1, width)
    else:
        values = document.read(sampler.get("output"), width)
    if mode == "CUBICSPLINE":
        values = np.reshape(values[: len(values) // 3 * 3], (-1, 3, width))
    if not len(times) or len(values) != len(times):
        raise FormatError(f"the {path} of node {node} has {len(times)} keys and {len(values)} values", remedy=DAMAGED)
    if not np.isfinite(times).all() or (np.diff(times) < 0).any():
        raise FormatError(f"the times of the {path} of node {node} do not increase", remedy=DAMAGED)
    return Track(node, path, mode, times, values)


def find_rate(tracks: list[Track]) -> tuple[float, bool]:
    """Frames a second by the distances of keys, and whether they show one.

    They do where 90 % of all distances are whole multiples of their median within 1 %. The rate is that of the whole
    span of the longest track, or 1 / the median where other keys are between its frames, and is taken to the nearest
    usual one within 0.1 % if this moves no frame by more than half a per cent of one. Tracks of two keys, a begin and
    an end, count only where none has more: two frames. 30 where the keys show none, or less than 10 a second.
    """
    least = min(3, max((len(track.times) for track in tracks), default=0))
    steps = [np.diff(track.times) for track in tracks if len(track.times) >= least]
    steps = [step[step > 0] for step in steps]
    together = np.concatenate(steps) if steps else np.empty(0)
    if not len(together):
        return DEFAULT_RATE, False
    step = float(np.median(together))
    if _are_whole(together / step).mean() < 0.9 or 1 / step < LEAST_RATE:
        return DEFAULT_RATE, False
    longest = max(steps, key=len)
    if _are_whole(longest / step).all():
        step = float(longest.sum() / np.round(longest / step).sum())
    rate = 1 / step
    near = min(_USUAL, key=lambda usual: abs(usual - rate))
    first, last = _span(tracks)
    moved = abs(near - rate) * (last - first)
    usual = abs(near - rate) <= 0.001 * near and moved <= _NEAR / 2 + rate * _rounding(last)
    return (near if usual else rate), True


def _are_whole(ratio: Array) -> NDArray[np.bool_]:
    return np.asarray((np.abs(ratio - np.round(ratio)) <= 0.01) & (np.round(ratio) >= 1))


def _span(tracks: list[Track]) -> tuple[float, float]:
    return min(float(track.times[0]) for track in tracks), max(float(track.times[-1]) for track in tracks)


def _rounding(time: float) -> float:
    """Seconds to the next time in single precision, in which glTF has its keys."""
    return float(np.spacing(np.float32(abs(time))))


def frame_times(tracks: list[Track], rate: float, shown: bool) -> Array:
    """(n,) seconds of the frames: from the first key of all tracks to the last. shown: by the keys, not asked for.

    A frame that is no farther from a key of the longest track than single precision explains, or than 1 % of a frame
    where the keys show the rate, has the time of this key, and so its values without interpolation.
    """
    first, last = _span(tracks)
    near = 2 * _rounding(last) + (_NEAR / rate if shown else 0)
    times = first + np.arange(int(np.floor((last - first + near) * rate)) + 1) / rate
    keys = max((track.times for track in tracks), key=len)
    place = np.clip(np.searchsorted(keys, times), 1, max(1, len(keys) - 1))
    for beside in (place - 1, np.minimum(place, len(keys) - 1)):
        times = np.where(np.abs(keys[beside] - times) <= near, keys[beside], times)
    return np.asarray(times)
