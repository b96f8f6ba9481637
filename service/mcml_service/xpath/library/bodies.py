"""Quantities of bodies in motion over a group of documents, as columns with a number for every frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from difflib import get_close_matches
from functools import cached_property, partial
from typing import TypeVar

import numpy as np

from mcml.errors import QueryError
from mcml.motion.bodies.pose_index import MADE as INDEX_MADE
from mcml.motion.bodies.pose_index import WIDTH, Balls, PoseIndex, balls_of, pose_index
from mcml.motion.bodies.poses import NEEDS, pose_features
from mcml.motion.bodies.quantities import AskedQuantity, compute, found_together, joints_of
from mcml.motion.bodies.stretch import Stretch
from mcml_service.clips.bodies import MADE, Body
from mcml_service.clips.frame_quantities import FrameQuantities, is_beside_positions
from mcml_service.clips.read_clip import Skeletons
from mcml_service.storage.documents.columns import Listed
from mcml_service.xpath.library.body_facts import BodyFacts
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.likeness import Asked, Poses
from mcml_service.xpath.library.pose_columns import PoseColumns
from mcml_service.xpath.nodes.numbering import FRAME_MASK, FRAME_SHIFT, Bools, Floats, Ints, documents_of, frames_of

Column = TypeVar("Column", Floats, PoseColumns)
Made = TypeVar("Made")
TOGETHER = 32
"""Documents whose bodies are read before anything else may happen."""
MOST_VALUES = 1 << 24
"""Numbers of quantities that are found together; beyond them, one quantity is found at a time."""


class Bodies:
    """Of the documents of a forest. check: called often; raises when time is up."""

    def __init__(self, forest: Forest, check: Callable[[], None]) -> None:
        self._forest = forest
        self._check = check

    @cached_property
    def offsets(self) -> Ints:
        """The index in a column at which the frames of each document begin; at the end, their total number."""
        return np.concatenate([[0], np.cumsum(self._forest.frames)]).astype(np.int64)

    @property
    def frames(self) -> Ints:
        """Of each document."""
        return self._forest.frames

    @cached_property
    def seconds(self) -> Floats:
        """Seconds a frame of each document, NaN where unknown."""

        def of_body(body: Body) -> float:
            return np.nan if body.frame_time is None else body.frame_time

        return self._forest.of_bodies((f"{MADE}", "seconds"), lambda: np.array(self._each(of_body), np.float64))

    def rows(self, nodes: Ints) -> Ints:
        """Return the index in a column of each node's frame; -1 for nodes of heads."""
        frames = frames_of(nodes)
        return np.where(frames > 0, self.offsets[documents_of(nodes)] + frames - 1, -1)

    def at(self, column: Floats, nodes: Ints) -> Floats:
        """Return the numbers that nodes have in a column: those of their frames, NaN for nodes of heads."""
        if not len(column) or not len(nodes):
            return np.full(len(nodes), np.nan)
        keys = nodes >> FRAME_SHIFT
        first, last = (int(row) for row in self.rows(nodes[[0, -1]]))
        if last - first == len(nodes) - 1 and (keys[1:] > keys[:-1]).all() and (keys & FRAME_MASK).all():
            # As many different frames as there are between these: all of them.
            return column[first : last + 1]
        rows = self.rows(nodes)
        return np.where(rows >= 0, column[rows], np.nan)

    def quantity(self, name: str, arguments: tuple[str, ...]) -> Floats:
        """A column of the quantity of a name."""

        together = found_together(name, arguments)
        if len(together) * int(self.offsets[-1]) > MOST_VALUES:
            together = (arguments,)
        found: dict[tuple[str, ...], Floats] = {}

        def make() -> Floats:
            found.update(zip(together, self._quantities(name, together), strict=True))
            return found[arguments]

        column = self._of_bodies(name, arguments, make)
        for others, values in found.items():
            self._of_bodies(name, others, partial(_same, values))
        return column

    def take(self, whole: Bodies, chosen: Bools, name: str, arguments: tuple[str, ...]) -> None:
        """Take the column of a quantity from the documents of a group that these are chosen from."""

        def make() -> Floats:
            return whole.quantity(name, arguments)[np.repeat(chosen, whole.frames)]

        self._of_bodies(name, arguments, make)

    def _of_bodies(self, name: str, arguments: tuple[str, ...], make: Callable[[], Floats]) -> Floats:
        return self._forest.of_bodies((f"{MADE}", name, *arguments), make)

    def _quantities(self, name: str, together: Sequence[tuple[str, ...]]) -> list[Floats]:
        """A column for each of some arguments, all of which need the same joints."""
        asked = [AskedQuantity("", name, arguments, "") for arguments in together]
        if is_beside_positions(asked[0]):
            return self._read(asked)

        def of_body(body: Body) -> list[Floats]:
            stretch = body.stretch(joints_of(name, together[0], body.names))
            return [compute(name, arguments, stretch) for arguments in together]

        return [np.concatenate(parts) for parts in zip(*self._each(of_body), strict=True)]

    def find_documents_without(self, name: str, arguments: tuple[str, ...]) -> Bools:
        """Which documents have no value of a measurement of the file, in any frame."""
        known = np.concatenate([[0], np.cumsum(~np.isnan(self.quantity(name, arguments)))])
        return np.asarray(known[self.offsets[1:]] == known[self.offsets[:-1]], bool)

    def of_documents(self, name: str) -> Floats:
        """A quantity that is the document's, of each document, whether it has frames or not."""

        def of_body(body: Body) -> float:
            return float(compute(name, (), Stretch({}, 1, body.frame_time, body.calibration))[0])

        return self._forest.of_bodies((f"{MADE}", "documents", name), lambda: np.array(self._each(of_body), np.float64))

    def _read(self, asked: Sequence[AskedQuantity]) -> list[Floats]:
        # Excluded documents are reported from the facts of bodies.
        self.facts()
        parts = []
        skeletons: Skeletons = {}
        for listed in self._forest.documents:
            self._check()
            (body,) = self._forest.caches.bodies.read(self._forest.tx, [listed])
            quantities = FrameQuantities(self._forest.tx, listed, body, skeletons)
            parts.append([quantities.read_known(each) for each in asked])
        return [np.concatenate(each) for each in zip(*parts, strict=True)]

    def asked(self, document: str, first: float, last: float | None) -> Asked:
        """Return the pose of a frame of a document; with `last`, the motion from there to that frame.

        document: an id, or a unique name. Raises QueryError for an unknown document or frame.
        """
        listed = self._named(document)
        end = first if last is None else last
        if not (first == int(first) and end == int(end) and 1 <= first <= end <= listed.frames):
            raise QueryError(f"{listed.name!r} has no such frames.", remedy=f"Its frames are 1 to {listed.frames}.")
        body = self._forest.caches.bodies.read(self._forest.tx, [listed])[0]
        poses = pose_features(body.stretch(NEEDS))[int(first) - 1 : int(end)]
        return Asked(poses, last is not None, body.frame_time)

    def distances(self, document: str, first: float, last: float | None) -> Floats:
        """Return a column of distances of all frames to the result of `asked`, or of the frame ranges that end
        there.
        """
        asked = self.asked(document, first, last)
        listed = self._named(document)

        def make() -> Floats:
            return asked.column(self.poses(), self.seconds, self._forest.frames, self._check)

        return self._column(("distance", listed.uuid, listed.revision, first, last), make)

    def poses(self) -> PoseColumns:
        """The poses in all frames."""

        def make() -> PoseColumns:
            vectors = np.concatenate(
                [np.empty((0, WIDTH), np.float32), *self._each(lambda body: Poses.of(body).vectors)]
            )
            return PoseColumns(vectors, self.offsets[:-1][self._forest.frames > 0])

        return self._column(("poses",), make)

    def pose_index(self) -> PoseIndex:
        """The index of the poses of all documents, stored on disk."""

        def balls(body: Body) -> Balls:
            poses = Poses.of(body)
            return balls_of(poses.vectors, poses.seconds)

        return self._forest.pose_index(f"{MADE} {INDEX_MADE}", lambda: pose_index(self._each(balls)))

    def _named(self, text: str) -> Listed:
        listing = self._forest.caches.listing
        whole = listing.whole(self._forest.tx, listing.state(self._forest.tx))
        found = [one for one in whole if one.uuid == text] or [one for one in whole if one.name == text]
        if len(found) == 1:
            return found[0]
        if found:
            ids = ", ".join(one.uuid for one in found[:5])
            raise QueryError(f"{len(found)} documents are named {text!r}.", remedy=f"Name it by its id: {ids}.")
        near = get_close_matches(text, [one.name for one in whole], 3)
        raise QueryError(
            f"There is no document {text!r}.",
            remedy=f"Did you mean {' or '.join(map(repr, near))}?" if near else "Give its id, or its name.",
        )

    def _column(self, key: tuple[object, ...], make: Callable[[], Column]) -> Column:
        samples = self._forest.caches.samples
        return samples.get(self._forest.documents, key, make, lambda column: column.nbytes)

    def facts(self) -> BodyFacts:
        """Return the facts of each document."""
        found = self._forest.body_facts(None)
        return self._gathered(lambda body: None)[1] if found is None else found

    def _each(self, function: Callable[[Body], Made]) -> list[Made]:
        """Return the results of a function for each body."""
        return self._gathered(function)[0]

    def _gathered(self, function: Callable[[Body], Made]) -> tuple[list[Made], BodyFacts]:
        """Return the results with the facts of bodies: reading bodies takes longest, so the facts are cached too."""
        found: list[Made] = []
        facts: list[BodyFacts] = []
        documents, caches = self._forest.documents, self._forest.caches
        for at in range(0, len(documents), TOGETHER):
            self._check()
            bodies = caches.bodies.read(self._forest.tx, documents[at : at + TOGETHER])
            found += map(function, bodies)
            facts.append(BodyFacts.of(bodies))
        together = BodyFacts.together(facts)
        self._forest.body_facts(lambda: together)
        return found, together


def _same(values: Floats) -> Floats:
    return values
