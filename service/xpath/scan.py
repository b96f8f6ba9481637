"""Questions about samples, answered from the tracks of the bones they name: zone maps first, then whole tracks at once.

`//frame[frame_bone[@name='A']/@Rx > frame_bone[@name='B']/@Rx]`, `//frame_bone[@name='A'][@Rx > 45]/@Ry` and their
like never look at other bones, and skip the tracks whose least and greatest samples rule them out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from service.mcml.lexical import unescape
from service.mcml.vocabulary import FRAME, FRAME_BONE, MCML, MOTION
from service.motion.skeleton import CHANNEL_INDEX
from service.storage.columns import Listed
from service.storage.database import Transaction
from service.storage.encoding import channels_of
from service.storage.tables import CHUNK
from service.xpath.axes import step as axis_step
from service.xpath.forest import Forest
from service.xpath.labels import motion_name_groups, ranges_of
from service.xpath.layouts import ShapeRuns
from service.xpath.numbering import DOCUMENT_SHIFT, FRAME_SHIFT, Bools, Floats, Ints, frames_of
from service.xpath.shared import Shared
from service.xpath.tree import Expression, Path
from service.xpath.vectors import Condition, Sample, attribute_conditions, bone_conditions, condition, conjunction

FIRST_UNITS = 128
"""Often the first page is all that is wanted."""
UNITS = 2048
"""Tracks of the leading bone that are looked at together: half a million samples a channel."""


@dataclass(frozen=True)
class ScanPlan:
    """What to scan for.

    condition: that a frame, or a frame_bone where `any_bone`, fulfils. lead: name of the bone whose tracks are looked
    through, None for all bones. names: groups of motion names, one of each of which the frame must carry.
    target: "frame" or "frame_bone". bone: the name of the frame_bone asked for, None for any that fulfils the condition
    (or all of the frame, where none is asked for something). attribute: of the target.
    """

    condition: Condition
    lead: str | None
    names: tuple[tuple[str, ...], ...]
    target: str
    bone: str | None
    attribute: str | None

    @property
    def any_bone(self) -> bool:
        return self.lead is None

    @property
    def sample(self) -> Sample | None:
        """The sample that is asked for, where the target is a channel that every hit has."""
        channel = CHANNEL_INDEX.get(self.attribute or "")
        found = None if channel is None or self.target == FRAME else (self.bone, channel)
        return found if found in self.condition.strict else None

    @property
    def one_each(self) -> bool:
        """Whether every frame (or track) that fulfils the condition gives exactly one node."""
        if self.target == FRAME:
            return self.attribute in (None, "id")
        own = any(name == self.bone for name, _ in self.condition.strict)
        return own and (self.attribute in (None, "name") or self.sample is not None)


def plan_scan(tree: Expression) -> ScanPlan | None:
    """The plan of a node set, in the form of `rules.normal`; None where samples do not decide it."""
    if not isinstance(tree, Path) or not tree.absolute or len(tree.steps) < 3:
        return None
    ways = [(step.axis, step.name) for step in tree.steps[:3]]
    if ways != [("child", MCML), ("child", MOTION), ("child", FRAME)] or any(s.predicates for s in tree.steps[:2]):
        return None
    names: list[tuple[str, ...]] = []
    conditions: list[Condition] = []
    for predicate in tree.steps[2].predicates:
        groups = motion_name_groups(predicate)
        found = condition(predicate, FRAME) if groups is None else None
        if groups is None and found is None:
            return None
        names += groups or ()
        conditions += [found] if found is not None else []
    steps = tree.steps[3:]
    target, bone = FRAME, None
    if steps and steps[0].name == FRAME_BONE:
        compiled = bone_conditions(steps[0])
        if compiled is None:
            return None
        target, (bone, own), steps = FRAME_BONE, compiled, steps[1:]
        conditions += own
    attribute = None
    if steps:
        compiled_attribute = attribute_conditions(steps[0], bone) if len(steps) == 1 else None
        if compiled_attribute is None or (target == FRAME and compiled_attribute[1]):
            return None
        attribute, on_attribute = compiled_attribute
        conditions += on_attribute
    if target == FRAME_BONE and attribute in CHANNEL_INDEX:
        sample = (bone, CHANNEL_INDEX[attribute])
        present = Condition(lambda block: ~np.isnan(block[sample]), frozenset({sample}), frozenset({sample}))
        conditions.append(present)
    if not conditions:
        return None
    whole = conjunction(conditions)
    if not whole.strict:
        return None
    lead = None
    if not any(name is None for name, _ in whole.samples):
        bounded = [name for (name, _), _, _ in whole.bounds if name is not None and (name, _) in whole.strict]
        lead = next(iter([*bounded, *sorted(name for name, _ in whole.strict if name is not None)]))
    elif not any(name is None for name, _ in whole.strict):
        return None
    return ScanPlan(whole, lead, tuple(names), target, bone, attribute)


class Scan:
    """Runs a plan over documents, given in order of the answer. whole_store: these are all there are."""

    def __init__(
        self,
        tx: Transaction,
        plan: ScanPlan,
        documents: Sequence[Listed],
        shared: Shared,
        check: Callable[[], None] = lambda: None,
        *,
        whole_store: bool = False,
    ) -> None:
        self.tx = tx
        self.plan = plan
        self._tracks = shared.tracks
        self._check = check
        self._whole_store = whole_store and not plan.names
        kept = list(documents)
        self._labelled = ranges_of(tx, plan.names, [listed.key for listed in kept]) if plan.names else None
        if self._labelled is not None:
            kept = [listed for listed in kept if listed.key in self._labelled]
        self.forest = Forest(tx, kept, shared, whole_heads=False)
        self._place = {listed.key: place for place, listed in enumerate(kept)}
        self._timeline = _Timeline(self.forest.shapes)
        self.rows_read = 0

    @property
    def documents(self) -> Sequence[Listed]:
        """Those that are looked at."""
        return self.forest.documents

    def chunks(self) -> Iterator[tuple[Forest, Ints]]:
        """The nodes of the answer in order, some at a time."""
        for hits in self._hits():
            nodes = self._targets(hits)
            if len(nodes):
                yield self.forest, nodes

    def count(self) -> int:
        """How many nodes the answer has."""
        if self.plan.one_each:
            return sum(hits.count for hits in self._hits())
        return sum(len(nodes) for _, nodes in self.chunks())

    def all_tracks(self) -> int:
        """How many tracks the leading bone has, those that zone maps rule out too."""
        lead = self.plan.lead
        if lead is None:
            return sum(1 for _ in self.tx.columns.tracks(self.forest.keys, None))
        return sum(1 for _ in self.tx.columns.tracks_named(unescape(lead), self.forest.keys))

    def samples(self, sample: Sample) -> Iterator[Floats]:
        """The numbers of the channel that is asked for, of all hits."""
        for hits in self._hits():
            yield hits.block[sample][hits.holds]

    def _targets(self, hits: _Hits) -> Ints:
        plan = self.plan
        frames, bones = hits.frames(self._timeline)
        nodes = frames
        if plan.target == FRAME_BONE and plan.any_bone:
            nodes = np.sort(self.forest.shapes.numbered(frames, bones))
        elif plan.target == FRAME_BONE:
            shapes = self.forest.shapes
            nodes = shapes.children(frames)[1] if plan.bone is None else shapes.named(frames, plan.bone)[1]
        return nodes if plan.attribute is None else axis_step(self.forest, nodes, "attribute", plan.attribute)[1]

    def _hits(self) -> Iterator[_Hits]:
        units = self._units()
        start, some = 0, FIRST_UNITS
        while start < len(units):
            stop = min(len(units), start + some)
            some = min(UNITS, some * 4)
            while self.plan.any_bone and stop < len(units) and units[stop][:2] == units[stop - 1][:2]:
                # The bones of one stretch of frames stay together, or the order of the answer would break.
                stop += 1
            self._check()
            found = self._look(units[start:stop])
            if found.count:
                yield found
            start = stop

    def _units(self) -> list[tuple[int, int, Any]]:
        """(document's place, chunk, row) of the leading tracks whose zone maps allow a hit, in order."""
        lead = self.plan.lead
        if lead is None:
            rows = list(self.tx.columns.tracks(self.forest.keys, None, None, self._bounds(None)))
        else:
            rows = list(self._rows(lead, None if self._whole_store else self.forest.keys, None))
            rows = [row for row in rows if row[0] in self._place]
        self.rows_read += len(rows)
        units = [(self._place[row[0]], row[1], row) for row in rows]
        units.sort(key=lambda unit: (unit[0], unit[1], unit[2][2]))
        return units

    def _rows(self, name: str, keys: Sequence[int] | None, chunks: tuple[int, int] | None) -> Iterator[Any]:
        return self.tx.columns.tracks_named(unescape(name), keys, chunks, self._bounds(name))

    def _bounds(self, name: str | None) -> list[tuple[str, int, float]]:
        """What zone maps must allow for a bone."""
        result = []
        for (bone, channel), operator, number in self.plan.condition.bounds:
            if bone == name:
                result += [("max", channel, number)] if operator in (">", ">=", "=") else []
                result += [("min", channel, number)] if operator in ("<", "<=", "=") else []
        return result

    def _look(self, units: Sequence[tuple[int, int, Any]]) -> _Hits:
        """The hits in some units."""
        condition = self.plan.condition
        columns: dict[Sample, Floats] = {}
        self._fill(columns, self.plan.lead, list(range(len(units))), [row for _, _, row in units], len(units))
        others = {name for name, _ in condition.samples} - {self.plan.lead}
        where: dict[tuple[int, int], list[int]] = {}
        for index, (place, chunk, _) in enumerate(units):
            where.setdefault((place, chunk), []).append(index)
        keys = [self.forest.keys[place] for place in dict.fromkeys(place for place, _, _ in units)]
        span = (min(unit[1] for unit in units), max(unit[1] for unit in units))
        for name in others:
            if name is None:
                continue
            rows, indices = [], []
            for row in self._rows(name, keys, span):
                for index in where.get((self._place[row[0]], row[1]), ()):
                    rows.append(row)
                    indices.append(index)
            self._fill(columns, name, indices, rows, len(units))
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            holds = condition.holds(columns)
        places = np.array([place for place, _, _ in units], np.int64)
        chunks = np.array([chunk for _, chunk, _ in units], np.int64)
        holds = holds & self._timeline.here(places, chunks)
        if self._labelled is not None:
            holds &= self._labels(places, chunks)
        return _Hits(holds, places, chunks, np.array([row[2] for _, _, row in units], np.int64), columns)

    def _labels(self, places: Ints, chunks: Ints) -> Bools:
        """Which frames carry the motion names that are asked for."""
        found = np.zeros((len(places), CHUNK), bool)
        positions = self._timeline.positions(places[:, None], slots_of_chunks(chunks))
        for place in np.unique(places).tolist():
            rows = np.flatnonzero(places == place)
            for first, last in (self._labelled or {})[self.forest.keys[place]]:
                found[rows] |= (positions[rows] >= first) & (positions[rows] <= last)
        return found

    def _fill(
        self, columns: dict[Sample, Floats], name: str | None, indices: Sequence[int], rows: Sequence[Any], units: int
    ) -> None:
        """Set the samples of a bone from its tracks."""
        wanted = [channel for bone, channel in self.plan.condition.samples if bone == name]
        for channel in wanted:
            columns[name, channel] = np.full((units, CHUNK), np.nan)
        for index, row, values in zip(indices, rows, self._tracks.read(self.tx, rows), strict=True):
            held = channels_of(row[4])
            for channel in wanted:
                if channel in held:
                    columns[name, channel][index, : values.shape[1]] = values[held.index(channel)]


@dataclass(frozen=True)
class _Hits:
    """holds: (units, CHUNK), where the condition is fulfilled. places, chunks: where a unit lies. bones: number of the
    bone of each leading track. block: the samples."""

    holds: Bools
    places: Ints
    chunks: Ints
    bones: Ints
    block: dict[Sample, Floats]

    @property
    def count(self) -> int:
        return int(np.count_nonzero(self.holds))

    def frames(self, timeline: _Timeline) -> tuple[Ints, Ints]:
        """The frames, and for each the bone."""
        unit, offset = np.nonzero(self.holds)
        positions = timeline.positions(self.places[unit], self.chunks[unit] * CHUNK + offset)
        frames = (self.places[unit] << DOCUMENT_SHIFT) | (positions << FRAME_SHIFT)
        bones = self.bones[unit]
        if len(frames) > 1 and (np.diff(frames) < 0).any():
            # Frames may have been put into another order than that of their slots.
            order = np.argsort(frames, kind="stable")
            return frames[order], bones[order]
        return frames, bones


def slots_of_chunks(chunks: Ints) -> Ints:
    """(n, CHUNK): the slots of each chunk."""
    return np.asarray(chunks[:, None] * CHUNK + np.arange(CHUNK), np.int64)


class _Timeline:
    """Where in their documents the frames of slots are."""

    def __init__(self, runs: ShapeRuns) -> None:
        slots = (runs.places << 32) | runs.slots
        order = np.argsort(slots)
        self._starts, self._count = slots[order], runs.counts[order]
        self._first = frames_of(runs.keys[order] << FRAME_SHIFT)

    def positions(self, places: Ints, slots: Ints) -> Ints:
        """The position of the frame in each slot, 0 where no frame of the document lies any more."""
        keys = (places << 32) | slots
        piece = np.searchsorted(self._starts, keys, side="right") - 1
        within = keys - self._starts[piece]
        return np.where((piece >= 0) & (within < self._count[piece]), self._first[piece] + within, 0)

    def here(self, places: Ints, chunks: Ints) -> Bools:
        """(units, CHUNK): in which slots frames lie."""
        first = (places << 32) | (chunks * CHUNK)
        piece = np.searchsorted(self._starts, first, side="right") - 1
        within = first - self._starts[piece]
        whole = (piece >= 0) & (within + CHUNK <= self._count[piece])
        found = np.ones((len(places), CHUNK), bool)
        part = np.flatnonzero(~whole)
        found[part] = self.positions(places[part, None], slots_of_chunks(chunks[part])) > 0
        return found
