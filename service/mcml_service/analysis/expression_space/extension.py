"""Add takes to an existing space, without building it again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space.frame_graph import FrameGraph
from mcml_service.analysis.expression_space.fuzzy_means import top_memberships
from mcml_service.analysis.expression_space.geodesics import from_sources
from mcml_service.analysis.expression_space.landmark_scale import Basis
from mcml_service.analysis.expression_space.neighbours import nearest
from mcml_service.analysis.expression_space.options import options_of
from mcml_service.analysis.expression_space.planar_map import Scaling
from mcml_service.analysis.expression_space.states import distances, state_vectors, step_lengths
from mcml_service.analysis.expression_space.stored import from_stored
from mcml_service.analysis.expression_space.takes import more_frames
from mcml_service.analysis.interface import AnalysisError, Motion, Part, Parts, Progress, silent

BLOCK = 500
STALE = 0.1
"""A space is to be built again when more than this share was added, or of the added frames is far from all others."""


@dataclass(frozen=True)
class Placed:
    """Frames placed in a space.

    near: (q, k) nearest existing frames of each; apart: (q, k) mm. geodesics: (q, l) to the base of the map (all
    existing frames, or landmarks). uncovered: share of the frames farther than tau from any.
    """

    near: NDArray[np.int32]
    apart: Array
    geodesics: Array
    uncovered: float


def nearest_frames(old: Array, new: Array, count: int) -> tuple[NDArray[np.int32], Array]:
    """Old frames nearest to each new one and their distances, (q, count), over all pairs of markers.

    old: (n, M, 3), new: (q, M, 3) positions, NaN where missing.
    """
    states = state_vectors(new)
    near = np.empty((len(new), 0), dtype=np.int32)
    apart = np.empty((len(new), 0))
    for start in range(0, len(old), BLOCK):
        block = distances(states, state_vectors(np.asarray(old[start : start + BLOCK], dtype=float)))
        frames = np.broadcast_to(np.arange(start, start + block.shape[1], dtype=np.int32), block.shape)
        near, apart = np.concatenate([near, frames], axis=1), np.concatenate([apart, block], axis=1)
        order = np.argsort(apart, axis=1, kind="stable")[:, :count]
        near, apart = np.take_along_axis(near, order, axis=1), np.take_along_axis(apart, order, axis=1)
    return near, apart


def nearest_reduced(old: Array, new: Array, count: int) -> tuple[NDArray[np.int32], Array]:
    """The same from reduced states, (n, d) and (q, d)."""
    apart, near = nearest(old, new, count)
    return near.astype(np.int32), apart


def place_frames(
    near: NDArray[np.int32], apart: Array, chain: Array, geodesics: NDArray[np.float32], tau: float
) -> Placed:
    """Return distances of new frames to the base of the map: over existing neighbours, and along the take's own chain.

    near, apart: (q, k). chain: (q - 1,) mm from each new frame to the next, infinite where a take ends. geodesics: (l,
    n) of the base of the map.
    """
    coordinates = np.empty((len(near), len(geodesics)))
    for start in range(0, len(near), BLOCK):
        part = slice(start, start + BLOCK)
        over = geodesics[:, near[part]].astype(float) + apart[part]
        coordinates[part] = over.min(axis=2).T
    # A frame may be nearer by way of those before and after it in its take.
    for frame in range(1, len(coordinates)):
        np.minimum(coordinates[frame], coordinates[frame - 1] + chain[frame - 1], out=coordinates[frame])
    for frame in range(len(coordinates) - 2, -1, -1):
        np.minimum(coordinates[frame], coordinates[frame + 1] + chain[frame], out=coordinates[frame])
    return Placed(near, apart, coordinates, float((apart[:, 0] > tau).mean()) if len(apart) else 0.0)


def extend(parts: Parts, motions: Sequence[Motion], progress: Progress = silent) -> Parts:
    """Return a space's parts with further takes; existing frames keep their places.

    Raises AnalysisError `already-there`, `marker-sets-disjoint`, `not-finite`.
    """
    motions = sorted(motions, key=lambda motion: motion.document)
    space = from_stored({name: part for name, part in parts.items() if name != "path"})
    values, arrays = space.values, parts["space"].arrays
    twice = [motion.document for motion in motions if motion.document in space.documents]
    if twice:
        raise AnalysisError(
            "already-there", f"Document {twice[0]} is in the space.", remedy="Add others, or build the space again."
        )
    progress("states", 0.0)
    options = options_of(values["method"], smooth_s=values["smooth_s"], gap_s=values["gap_s"])
    neutral = np.asarray(space.positions[values["neutral"]], dtype=float)
    positions, kept, excluded = more_frames(motions, values["markers"], neutral, options)
    take = np.repeat(np.arange(len(motions)), [len(places) for places in kept]).astype(np.int32)
    frame = np.concatenate(kept).astype(np.int32)
    landmarks = "landmarks" in arrays
    progress("distances", 0.1)
    reduced = np.empty((0, 0))
    if landmarks:
        reduced = Basis(arrays["basis_mean"], arrays["basis"], 0.0).reduce(positions)
        near, apart = nearest_reduced(np.asarray(arrays["states"], dtype=float), reduced, values["neighbours"])
    else:
        near, apart = nearest_frames(space.positions, positions, values["neighbours"])
    after = (np.diff(take) == 0) & (np.diff(frame) == 1)
    chain = np.where(after, _steps(positions, reduced), np.inf)
    progress("geodesics", 0.6)
    placed = place_frames(near, apart, chain, arrays["geodesics"], values["tau"])
    graph = _with_frames(space.ground.graph, placed, chain)
    if landmarks:
        geodesics = np.concatenate([arrays["geodesics"], placed.geodesics.T.astype(np.float32)], axis=1)
    else:
        rows = from_sources(graph.matrix, np.arange(len(space.take), graph.frames)).astype(np.float32)
        geodesics = np.concatenate([arrays["geodesics"], rows[:, : len(space.take)].T], axis=1)
        geodesics = np.concatenate([geodesics, rows], axis=0)
    progress("map", 0.9)
    coordinates = np.asarray(parts["map"].arrays["coordinates"])
    of_map = np.asarray(arrays["landmark_coordinates"]) if landmarks else coordinates[: len(arrays["squared_mean"])]
    scaling = Scaling(of_map, np.asarray(arrays["eigenvalues"]), np.asarray(arrays["squared_mean"]), 0.0)
    new = scaling.place(placed.geodesics[:, : len(of_map)] ** 2)
    takes = take + len(space.documents)
    arrays = dict(arrays)
    missing = np.isnan(positions[..., 0])
    if missing.any() or "missing" in arrays:
        before = arrays.get("missing", np.zeros((len(space.take), positions.shape[1]), np.uint8))
        arrays["missing"] = np.concatenate([before, missing.astype(np.uint8)])
    kind = arrays["positions"].dtype
    arrays["positions"] = np.concatenate([arrays["positions"], np.nan_to_num(positions).astype(kind)])
    arrays["take"], arrays["frame"] = np.concatenate([space.take, takes]), np.concatenate([space.frame, frame])
    arrays |= {
        "edge_first": graph.first,
        "edge_second": graph.second,
        "edge_length": graph.length.astype(np.float32),
        "geodesics": geodesics,
    }
    if landmarks:
        arrays["states"] = np.concatenate([arrays["states"], reduced.astype(np.float32)])
    names = [motion.name for motion in motions]
    documents = [motion.document for motion in motions]
    return {
        **{name: part for name, part in parts.items() if name != "path"},
        "space": Part("model", _more_values(parts["space"].data, motions, len(take), placed.uncovered), arrays),
        "map": Part(
            "points",
            {
                **parts["map"].data,
                "documents": [*parts["map"].data["documents"], *documents],
                "names": [*parts["map"].data["names"], *names],
            },
            {
                "coordinates": np.concatenate([coordinates, new]),
                "take": arrays["take"],
                "frame": arrays["frame"],
            },
        ),
        "levels": _more_members(parts["levels"], new, len(space.take), values),
        "takes": _more_rows(
            parts["takes"],
            [[m.document, m.revision, m.name, m.fps, len(m), len(k)] for m, k in zip(motions, kept, strict=True)],
        ),
        "excluded": _more_rows(
            parts["excluded"], [[documents[number], place + 1, why] for number, place, why in excluded]
        ),
    }


def _steps(positions: Array, reduced: Array) -> Array:
    """(q - 1,) mm from each new frame to the next."""
    if len(reduced):
        lengths: Array = np.linalg.norm(np.diff(reduced, axis=0), axis=1)
        return lengths
    return step_lengths(positions)


def _with_frames(graph: FrameGraph, placed: Placed, chain: Array) -> FrameGraph:
    """The graph with new frames, each joined to its old neighbours and to the next of its take."""
    count, old = len(placed.near), graph.frames
    new = np.repeat(np.arange(old, old + count, dtype=np.int32), placed.near.shape[1])
    steps = np.flatnonzero(np.isfinite(chain))
    first = np.concatenate([placed.near.reshape(-1), steps + old]).astype(np.int32)
    second = np.concatenate([new, steps + old + 1]).astype(np.int32)
    length = np.concatenate([placed.apart.reshape(-1), chain[steps]])
    held = np.isfinite(length)
    return FrameGraph(
        old + count,
        np.concatenate([graph.first, first[held]]),
        np.concatenate([graph.second, second[held]]),
        np.concatenate([graph.length, length[held]]),
        np.concatenate([graph.bridge, np.zeros(int(held.sum()), dtype=bool)]),
    )


def _more_values(data: Mapping[str, Any], motions: Sequence[Motion], count: int, uncovered: float) -> dict[str, Any]:
    values, summary = dict(data["values"]), dict(data["summary"])
    added = values["added"] + count
    far = (summary["uncovered"] * values["added"] + uncovered * count) / max(added, 1)
    share = added / (summary["frames"] + count)
    values |= {
        "documents": [*values["documents"], *(motion.document for motion in motions)],
        "names": [*values["names"], *(motion.name for motion in motions)],
        "fps": [*values["fps"], *(motion.fps for motion in motions)],
        "added": added,
        "version": values["version"] + 1,
    }
    warnings = [warning for warning in summary["warnings"] if warning["code"] != "stale"]
    if share > STALE or far > STALE:
        text = f"{100 * share:.0f} % of the frames were added, {100 * far:.0f} % of these are far from all others: "
        warnings.append({"code": "stale", "what": text + "build the space again."})
    summary |= {
        "frames": summary["frames"] + count,
        "takes": summary["takes"] + len(motions),
        "added": added,
        "stale_share": share,
        "uncovered": far,
        "version": values["version"],
        "warnings": warnings,
    }
    return {**data, "values": values, "summary": summary}


def _more_members(part: Part, new: Array, old: int, values: Mapping[str, Any]) -> Part:
    """Return memberships of new frames with unchanged centres (5.2), and the candidate nearest to each."""
    arrays, points = dict(part.arrays), new[:, : values["cluster_dimensions"]]
    first = np.asarray(arrays["first"])
    if first[-1] - first[-2] == old:
        more = np.arange(old, old + len(new), dtype=np.int32)
        arrays["candidates"] = np.concatenate([arrays["candidates"], more])
        arrays["first"] = np.append(first[:-1], first[-1] + len(new))
    if "members" in arrays:
        members, shares, owners = [], [], []
        spans = np.asarray(arrays["centre_first"])
        for start, stop in pairwise(spans):
            which, share = top_memberships(points, arrays["centres"][start:stop], values["fuzziness"])
            columns = [min(column, which.shape[1] - 1) for column in range(3)]
            stands = arrays["stands"][start:stop]
            members.append(stands[which][:, columns])
            shares.append(share[:, columns])
            owners.append(stands[nearest(arrays["centres"][start:stop], points)[1][:, 0]])
        arrays["members"] = np.concatenate([arrays["members"], np.stack(members)], axis=1)
        arrays["shares"] = np.concatenate([arrays["shares"], np.stack(shares).astype(np.float32)], axis=1)
        arrays["nearest"] = np.concatenate([arrays["nearest"], np.stack(owners)], axis=1)
    return replace(part, arrays=arrays)


def _more_rows(part: Part, rows: Sequence[Sequence[Any]]) -> Part:
    return replace(part, data={**part.data, "rows": [*part.data["rows"], *map(list, rows)]})
