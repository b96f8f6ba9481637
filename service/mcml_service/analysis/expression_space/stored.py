"""A space as operations use it, from the parts of a stored result; and a path, from and to its part."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space.frame_graph import FrameGraph
from mcml_service.analysis.expression_space.links import Links
from mcml_service.analysis.expression_space.navigation import Ground, Walk, walk_over
from mcml_service.analysis.interface import AnalysisError, Part, Parts


@dataclass(frozen=True)
class Path:
    """A path with the level of its last keys, its version, and its lost keys."""

    walk: Walk
    level: int
    version: int
    warnings: tuple[tuple[str, str], ...] = ()


@dataclass
class Stored:
    """A stored space, and the path of the result if it is one. nearest: (levels, n) candidate of each frame."""

    ground: Ground
    positions: Array
    take: NDArray[np.int32]
    frame: NDArray[np.int32]
    values: Mapping[str, Any]
    summary: Mapping[str, Any]
    levels: Sequence[Mapping[str, Any]]
    sizes: Sequence[NDArray[np.int64]]
    components: Sequence[int]
    path: Path | None = None

    @property
    def documents(self) -> Sequence[str]:
        uuids: Sequence[str] = self.values["documents"]
        return uuids

    @cached_property
    def places(self) -> Mapping[tuple[str, int], int]:
        """The number of each frame, by document and 0-based position in the take."""
        documents = self.documents
        return {
            (documents[take], frame): number
            for number, (take, frame) in enumerate(zip(self.take.tolist(), self.frame.tolist(), strict=True))
        }

    def number(self, document: str, position: int) -> int:
        """The number of a frame, from its document and its position from 1. Raises AnalysisError `unknown-frame`."""
        place = self.places.get((document, position - 1))
        if place is None:
            raise AnalysisError(
                "unknown-frame",
                f"The space has no frame {position} of document {document!r}.",
                remedy="Frames count from 1; the parts takes and excluded say which are used.",
            )
        return place

    def check_level(self, level: int) -> int:
        """Raises AnalysisError `unknown-level`."""
        if level >= len(self.ground.candidates):
            raise AnalysisError(
                "unknown-level",
                f"The space has no level {level}.",
                remedy=f"Levels are 0 to {len(self.ground.candidates) - 1}.",
            )
        return level


def from_stored(parts: Parts) -> Stored:
    """The space, and the path, of stored parts; nothing is computed again."""
    space, points, levels, links = (parts[name] for name in ("space", "map", "levels", "links"))
    arrays = space.arrays
    count = len(arrays["take"])
    bridge = np.zeros(len(arrays["edge_first"]), dtype=bool)
    bridge[arrays["bridges"]] = True
    graph = FrameGraph(
        count,
        np.asarray(arrays["edge_first"]),
        np.asarray(arrays["edge_second"]),
        np.asarray(arrays["edge_length"], dtype=float),
        bridge,
    )
    first = np.asarray(levels.arrays["first"])
    candidates = [np.asarray(levels.arrays["candidates"][a:b]) for a, b in pairwise(first)]
    about = links.data["levels"]
    ground = Ground(
        graph,
        np.asarray(points.arrays["coordinates"])[:, :2],
        candidates,
        [_links(links, entry) if entry["listed"] else None for entry in about],
        None if "landmarks" in arrays else np.asarray(arrays["geodesics"]),
    )
    positions = np.asarray(arrays["positions"])
    if "missing" in arrays:
        positions = np.where(np.asarray(arrays["missing"], dtype=bool)[..., None], np.nan, positions)
    owners = levels.arrays.get("nearest", np.empty((0, count), dtype=np.int32))
    sizes = [np.bincount(owner, minlength=len(own)) for owner, own in zip(owners, candidates, strict=False)]
    sizes += [np.ones(len(own), dtype=np.int64) for own in candidates[len(sizes) :]]
    names = [column["name"] for column in levels.data["columns"]]
    stored = Stored(
        ground=ground,
        positions=positions,
        take=np.asarray(arrays["take"]),
        frame=np.asarray(arrays["frame"]),
        values=space.data["values"],
        summary=space.data["summary"],
        levels=[dict(zip(names, row, strict=True)) for row in levels.data["rows"]],
        sizes=sizes,
        components=[entry["components"] for entry in about],
    )
    # Made once, here, so that operations answer in milliseconds.
    _ = graph.matrix
    if "path" in parts:
        stored.path = _path(stored, parts["path"].data["path"])
    return stored


def on_path(space: Stored, parts: Parts) -> Stored:
    """The same space with the path that an operation kept."""
    child = copy(space)
    child.path = _path(space, parts["path"].data["path"])
    return child


def _links(part: Part, about: Mapping[str, Any]) -> Links:
    first = part.arrays["first"]
    span = slice(int(first[about["level"]]), int(first[about["level"] + 1]))
    arrays = part.arrays
    return Links(
        np.asarray(arrays["a"][span]),
        np.asarray(arrays["b"][span]),
        np.asarray(arrays["length"][span], dtype=float),
        np.asarray(arrays["bridge"][span], dtype=bool),
        about["components"],
    )


def _path(space: Stored, kept: Mapping[str, Any]) -> Path:
    """Return the path over the remaining keys.

    Keys that the space does not have (any more) are left out and reported.
    """
    keys: list[int] = []
    lost: list[str] = []
    for document, frame in kept["keys"]:
        number = space.places.get((document, frame - 1))
        if number is None:
            lost.append(f"frame {frame} of {document}")
        elif not keys or keys[-1] != number:
            keys.append(number)
    if len(keys) < 2:
        raise AnalysisError("keys-lost", "Fewer than two keys of the path are in the space.", remedy="Make it again.")
    warnings = [("keys-lost", f"The space does not have {', '.join(lost[:20])}.")] if lost else []
    return Path(walk_over(space.ground, keys), kept["level"], kept["version"], tuple(warnings))


def path_part(space: Stored, path: Path) -> Part:
    """A path to be kept: frames by document and position, so that it survives a rebuild. A row a frame of the walk."""
    walk = path.walk
    at = set(walk.at.tolist())
    rows = [
        [space.documents[space.take[number]], int(space.frame[number]) + 1, float(position), place in at]
        for place, (number, position) in enumerate(zip(walk.frames.tolist(), walk.position, strict=True))
    ]
    columns = [("document", ""), ("frame", ""), ("position", "mm"), ("key", "")]
    return Part(
        "table",
        {
            "columns": [{"name": name, "unit": unit} for name, unit in columns],
            "rows": rows,
            "path": {
                "version": path.version,
                "level": path.level,
                "keys": [rows[place][:2] for place in walk.at.tolist()],
                "length_mm": walk.length,
                "largest_hop_mm": walk.largest_hop,
                "bridges": walk.bridges,
            },
        },
        {"walk": walk.frames, "position": walk.position, "at": walk.at},
    )
