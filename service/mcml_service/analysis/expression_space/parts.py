"""A space as the parts of a stored result: data for operations, and data for people.

A table has data `columns` (name, unit) and `rows`; a curve has `x` and `y` (name, unit) and arrays of these names.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml_service.analysis.expression_space.space import Space
from mcml_service.analysis.interface import Part, Parts

Arrays = dict[str, NDArray[Any]]


def parts_of(space: Space) -> Parts:
    """All parts of a new space."""
    return {
        "space": Part("model", _values(space), _arrays(space)),
        "map": _map(space),
        "levels": _levels(space),
        "links": _links(space),
        "tau": _tau(space),
        "fit": _table(
            [("dimensions", ""), ("r", ""), ("stress", "")],
            [[agreement.dimensions, plain(agreement.r), plain(agreement.stress)] for agreement in space.agreements],
        ),
        "objective": _objective(space),
        "takes": _table(
            [("document", ""), ("revision", ""), ("name", ""), ("fps", "1/s"), ("frames", ""), ("used", "")],
            [[t.document, t.revision, t.name, t.fps, t.frames, t.kept] for t in space.frames.takes],
        ),
        "markers": _table(
            [("marker", ""), ("used", ""), ("why", "")],
            [[name, True, None] for name in space.frames.markers]
            + [[name, False, why] for name, why in space.frames.dropped],
        ),
        "excluded": _table(
            [("document", ""), ("frame", ""), ("why", "")],
            [[space.frames.takes[take].document, frame + 1, why] for take, frame, why in space.frames.excluded],
        ),
    }


def plain(value: float | None) -> float | None:
    """Return a number for JSON: null without one."""
    return float(value) if value is not None and math.isfinite(value) else None


def _table(columns: Sequence[tuple[str, str]], rows: Sequence[Sequence[Any]]) -> Part:
    heads = [{"name": name, "unit": unit} for name, unit in columns]
    return Part("table", {"columns": heads, "rows": [list(row) for row in rows]})


def _values(space: Space) -> dict[str, Any]:
    frames, options, count = space.frames, space.options, len(space.frames.take)
    neutral = frames.takes[frames.take[frames.neutral]]
    return {
        "summary": {
            "method": options.method,
            "scale": "full" if space.reduced is None else "landmark",
            "version": 1,
            "frames": count,
            "takes": len(frames.takes),
            "markers": len(frames.markers),
            "markers_dropped": [{"marker": name, "why": why} for name, why in frames.dropped],
            "frames_excluded": len(frames.excluded),
            "tau_mm": space.tau,
            "tau_rms_mm": space.tau / len(frames.markers),
            "connecting_tau_mm": plain(space.connecting),
            "mean_degree": space.graph.mean_degree(),
            "components": list(space.components[:100]),
            "bridges": int(space.graph.bridge.sum()),
            "r": plain(space.agreements[0].r),
            "stress": plain(space.agreements[0].stress),
            "trustworthiness": space.neighbourhoods[0],
            "continuity": space.neighbourhoods[1],
            "eigenvalues": [float(value) for value in space.scaling.eigenvalues],
            "negative_share": plain(space.scaling.negative),
            "levels": len(space.levels),
            "speed_mm_s": space.speed,
            "neutral": {"document": neutral.document, "frame": int(frames.frame[frames.neutral]) + 1},
            "added": 0,
            "stale_share": 0.0,
            "uncovered": 0.0,
            "warnings": [{"code": code, "what": text} for code, text in space.warnings],
        },
        "values": {
            "documents": [take.document for take in frames.takes],
            "names": [take.name for take in frames.takes],
            "fps": [take.fps for take in frames.takes],
            "markers": list(frames.markers),
            "up": frames.up,
            "neutral": frames.neutral,
            "speed": space.speed,
            "tau": space.tau,
            "method": options.method,
            "fuzziness": options.fuzziness,
            "cluster_dimensions": options.cluster_dimensions,
            "neighbours": options.neighbours,
            "smooth_s": options.smooth_s,
            "gap_s": options.gap_s,
            "added": 0,
            "version": 1,
        },
    }


def _arrays(space: Space) -> Arrays:
    frames, graph = space.frames, space.graph
    missing = np.isnan(frames.positions[..., 0])
    # Large spaces are kept in single precision: a ten-thousandth of a millimetre.
    number = np.float64 if space.reduced is None else np.float32
    arrays: Arrays = {
        "positions": np.where(missing[..., None], 0.0, frames.positions).astype(number),
        "take": frames.take,
        "frame": frames.frame,
        "edge_first": graph.first,
        "edge_second": graph.second,
        "edge_length": graph.length.astype(np.float32),
        "bridges": np.flatnonzero(graph.bridge).astype(np.int32),
        "eigenvalues": space.scaling.eigenvalues,
        "squared_mean": space.scaling.mean,
    }
    if missing.any():
        arrays["missing"] = missing.astype(np.uint8)
    if space.geodesics is not None:
        arrays["geodesics"] = space.geodesics
    if space.reduced is not None:
        arrays |= {
            "geodesics": space.reduced.geodesics,
            "landmarks": space.reduced.landmarks,
            "landmark_coordinates": space.scaling.coordinates,
            "states": space.reduced.states.astype(np.float32),
            "basis": space.reduced.basis.components,
            "basis_mean": space.reduced.basis.mean,
        }
    return arrays


def _map(space: Space) -> Part:
    """Return the map of the frames: coordinates (n, p) mm, the first two of them for display; take and frame
    (0-based).
    """
    frames = space.frames
    data = {
        "documents": [take.document for take in frames.takes],
        "names": [take.name for take in frames.takes],
        "unit": "mm",
        "dimensions": space.coordinates.shape[1],
    }
    return Part("points", data, {"coordinates": space.coordinates, "take": frames.take, "frame": frames.frame})


def _levels(space: Space) -> Part:
    """A row a level. Arrays hold the levels end to end, level l from `first[l]` on, as does `centre_first` for centres.
    members, shares, nearest: (levels but one with all frames, n, …)."""
    columns = [
        *(("level", ""), ("wanted", ""), ("candidates", ""), ("unique", ""), ("coverage", "mm"), ("iterations", "")),
        *(("objective", "mm2"), ("links", ""), ("components", ""), ("rho", "mm")),
    ]
    rows = [
        [
            number,
            level.wanted,
            len(level.candidates),
            level.unique,
            level.coverage,
            len(level.objective),
            float(level.objective[-1]) if len(level.objective) else None,
            len(links.first),
            links.components,
            radius,
        ]
        for number, (level, links, radius) in enumerate(zip(space.levels, space.links, space.radii, strict=True))
    ]
    grouped = [level for level in space.levels if len(level.candidates) < len(space.frames.take)]
    arrays: Arrays = {
        "candidates": np.concatenate([level.candidates for level in space.levels]),
        "first": _offsets([len(level.candidates) for level in space.levels]),
    }
    if grouped:
        arrays |= {
            "members": np.stack([level.members[:, _columns(level.members)] for level in grouped]),
            "shares": np.stack([level.shares[:, _columns(level.shares)] for level in grouped]).astype(np.float32),
            "nearest": np.stack([level.nearest for level in grouped]),
            "centres": np.concatenate([level.centres for level in grouped]),
            "stands": np.concatenate([level.stands for level in grouped]),
            "centre_first": _offsets([len(level.centres) for level in grouped]),
        }
    part = _table(columns, rows)
    return Part("table", part.data, arrays)


def _columns(values: NDArray[Any]) -> list[int]:
    """Three columns of memberships, also with only two clusters: the last is repeated."""
    return [min(column, values.shape[1] - 1) for column in range(3)]


def _offsets(counts: Sequence[int]) -> NDArray[np.int64]:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


def _links(space: Space) -> Part:
    """Links of all levels end to end, level l from `first[l]` on: numbers of candidates `a` and `b` of the level,
    length mm, bridge. The level that has every frame has no list: its links are the edges of the frame graph."""
    count = len(space.frames.take)
    listed = [
        None if len(level.candidates) == count else links
        for level, links in zip(space.levels, space.links, strict=True)
    ]
    data = {
        "levels": [
            {"level": number, "links": len(links.first), "components": links.components, "listed": found is not None}
            for number, (links, found) in enumerate(zip(space.links, listed, strict=True))
        ],
        "unit": "mm",
    }
    held = [links for links in listed if links is not None]
    arrays: Arrays = {"first": _offsets([0 if links is None else len(links.first) for links in listed])}
    arrays["a"] = np.concatenate([links.first for links in held] or [np.empty(0, np.int32)])
    arrays["b"] = np.concatenate([links.second for links in held] or [np.empty(0, np.int32)])
    arrays["length"] = np.concatenate([links.length for links in held] or [np.empty(0)]).astype(np.float32)
    arrays["bridge"] = np.concatenate([links.bridge for links in held] or [np.empty(0, bool)]).astype(np.uint8)
    return Part("graph", data, arrays)


def _tau(space: Space) -> Part:
    names = ("tau", "broken", "r", "stress", "components", "giant", "degree", "stretch")
    data: Mapping[str, Any] = {
        "x": {"name": "tau", "unit": "mm"},
        "y": {"name": "r", "unit": ""},
        "chosen": space.tau,
        "connecting": plain(space.connecting),
        "rows": [{name: plain(getattr(trial, name)) for name in names} for trial in space.tried],
    }
    columns = {name: np.array([getattr(trial, name) for trial in space.tried], dtype=float) for name in names}
    return Part("curve", data, {name: np.nan_to_num(column, nan=0.0) for name, column in columns.items()})


def _objective(space: Space) -> Part:
    """J of every iteration, levels end to end, level l from `first[l]` on."""
    data = {"x": {"name": "iteration", "unit": ""}, "y": {"name": "objective", "unit": "mm2"}}
    runs = [level.objective for level in space.levels]
    arrays = {
        "iteration": np.concatenate([np.arange(1, len(run) + 1) for run in runs]),
        "objective": np.concatenate(runs),
        "first": _offsets([len(run) for run in runs]),
    }
    return Part("curve", data, arrays)
