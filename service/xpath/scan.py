"""Questions about samples, answered from the tracks of the bones they name: zone maps first, then whole tracks at once.

`//frame[frame_bone[@name='A']/@Rx > frame_bone[@name='B']/@Rx]`, `//frame_bone[@name='A'][@Rx > 45]/@Ry` and their
like never look at other bones, and skip the tracks whose least and greatest samples rule them out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from service.mcml.lexical import unescape
from service.mcml.vocabulary import FRAME, FRAME_BONE, MCML, MOTION
from service.motion.skeleton import CHANNEL_INDEX
from service.storage.blocks import Some, evenly
from service.storage.columns import Listed
from service.storage.database import Transaction
from service.storage.encoding import channels_of
from service.storage.schema import CHUNK
from service.xpath.axes import step as axis_step
from service.xpath.caches import Caches
from service.xpath.forest import Forest
from service.xpath.intervals import Interval
from service.xpath.labels import motion_name_groups, ranges_of
from service.xpath.numbering import DOCUMENT_SHIFT, FRAME_SHIFT, Bools, Floats, Ints
from service.xpath.timeline import Timeline, slots_of_chunks
from service.xpath.tree import Expression, Path
from service.xpath.vectors import (
    Condition,
    Sample,
    attribute_conditions,
    bone_conditions,
    condition,
    conjunction,
    present,
)
from service.xpath.zones import BITS, BONE, CHUNK_NUMBER, FRAMES, MANY_FRAMES, Table, joined, read_zones, rows_of

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
        conditions.append(present((bone, CHANNEL_INDEX[attribute])))
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
    """Runs a plan over documents, given in order of the answer."""

    def __init__(
        self,
        tx: Transaction,
        plan: ScanPlan,
        documents: Sequence[Listed],
        caches: Caches,
        check: Callable[[], None] = lambda: None,
    ) -> None:
        self.tx = tx
        self.plan = plan
        self._caches = caches
        self._check = check
        kept = list(documents)
        self._labelled = ranges_of(tx, plan.names, [listed.key for listed in kept]) if plan.names else None
        if self._labelled is not None:
            kept = [listed for listed in kept if listed.key in self._labelled]
        self.forest = Forest(tx, kept, caches, whole_heads=False)
        self._timeline = self.forest.timeline
        self.tracks_read = 0

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
        return sum(len(self._tracks(some, self.plan.lead)) for some in self._batches())

    def samples(self, sample: Sample) -> Iterator[Floats]:
        """The numbers of the channel that is asked for, of all hits."""
        for units in self._units():
            for some in self._parts(units):
                block = self._read(some)
                yield block[sample][self._holds(some, block)]

    def extremes(self, sample: Sample, *, greatest: bool) -> Iterator[Floats]:
        """The greatest (or least) number of that channel, where there is any.

        Of tracks all of whose frames are hits, zone maps tell it; others are read while they may hold a greater one.
        """
        sign = 1.0 if greatest else -1.0
        best = -np.inf
        for units in self._units():
            ends = units.ends(sample)
            most = ends.high if greatest else -ends.low
            whole = units.must & (self._there(units).sum(axis=1) == units.lead.about[FRAMES])
            if whole.any():
                best = max(best, float(most[whole].max()))
            rest = np.flatnonzero(~whole)
            rest = rest[np.argsort(-most[rest], kind="stable")]
            for start in range(0, len(rest), FIRST_UNITS):
                some = rest[start : start + FIRST_UNITS]
                some = some[most[some] > best]
                if not len(some):
                    break
                self._check()
                block = self._read(units[some])
                values = sign * block[sample][self._holds(units[some], block)]
                best = max(best, float(values.max(initial=-np.inf)))
        if best > -np.inf:
            yield np.array([sign * best])

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
        for units in self._units():
            for some in self._parts(units):
                holds = np.arange(CHUNK) < some.lead.about[FRAMES][:, None]
                unsure = np.flatnonzero(~some.must)
                if len(unsure):
                    holds[unsure] = self._fulfil(self._read(some[unsure]))
                holds &= self._there(some)
                if holds.any():
                    yield _Hits(holds, some.lead)

    def _parts(self, units: _Units) -> Iterator[_Units]:
        """Units that are looked at together. The first are few: often the first page is all that is wanted."""
        places, chunks = units.lead.places, units.lead.about[CHUNK_NUMBER]
        # Frames whose order is not that of their slots stay together, and so do the bones of one stretch of frames, or
        # the order of the answer would break.
        moved = np.isin(places, self._timeline.moved)
        edges = np.flatnonzero((np.diff(places) != 0) | ((np.diff(chunks) != 0) & ~moved[1:])) + 1
        start, some = 0, FIRST_UNITS
        while start < len(units):
            self._check()
            found = np.searchsorted(edges, start + some)
            stop = int(edges[found]) if found < len(edges) else len(units)
            yield units[start:stop]
            start, some = stop, min(UNITS, some * 4)

    def _units(self) -> Iterator[_Units]:
        """The leading tracks that may hold a hit, some documents at a time, in the order of their frames."""
        condition, lead_name = self.plan.condition, self.plan.lead
        names = {name for name, _ in condition.samples if name is not None} - {lead_name}
        for places in self._batches():
            lead = self._tracks(places, lead_name)
            if not len(lead):
                continue
            others = {name: self._tracks(places, name).facing(lead) for name in names}
            units = _Units(lead, others, np.zeros(len(lead), bool))
            verdict = condition.judge({sample: units.ends(sample) for sample in condition.samples})
            order = np.flatnonzero(verdict.may)
            if self.plan.any_bone:
                order = order[np.lexsort((*lead.about[[BONE, CHUNK_NUMBER]][:, order], lead.places[order]))]
            if len(order):
                yield _Units(lead, others, verdict.must)[order]

    def _batches(self) -> Iterator[range]:
        """The places of documents whose zone maps are looked at together."""
        start = frames = 0
        for place, stored in enumerate(self.forest.documents):
            if frames and frames + stored.frames > MANY_FRAMES:
                yield range(start, place)
                start, frames = place, 0
            frames += stored.frames
        yield range(start, len(self.forest))

    def _tracks(self, places: range, name: str | None) -> Table:
        """The tracks of the bone of a name, or of all bones, of some documents."""
        documents = self.forest.documents[places.start : places.stop]
        part = Forest(self.tx, documents, self._caches, whole_heads=False)
        if name is None:
            return part.tracks.moved(places.start)
        stored = unescape(name)
        numbers = [layout.numbers.get(stored, -1) for layout in part.layouts]
        if len(documents) == 1 and not part.has_tracks():
            return joined([read_zones(self.tx, documents, numbers)[documents[0].key]]).moved(places.start)
        return part.tracks.of_bones(numbers).moved(places.start)

    def _read(self, units: _Units) -> dict[Sample, Floats]:
        """The samples that the condition reads, (units, CHUNK), NaN where a frame has none."""
        self.tracks_read += len(units)
        block: dict[Sample, Floats] = {}
        for name, table in [(self.plan.lead, units.lead), *units.others.items()]:
            wanted = tuple(sorted(channel for bone, channel in self.plan.condition.samples if bone == name))
            held = np.flatnonzero(table.about[BITS])
            bits = table.about[BITS, held].tolist()
            places = {each: _places(each, wanted) for each in set(bits)}
            values = np.full((len(wanted), len(units), CHUNK), np.nan)
            tracks = self._caches.tracks.read(self.tx, rows_of(table.about[:, held]))
            for unit, track, each in zip(held.tolist(), tracks, bits, strict=True):
                here, there = places[each]
                values[here, unit, : track.shape[1]] = track[there]
            block |= {(name, channel): found for channel, found in zip(wanted, values, strict=True)}
        return block

    def _fulfil(self, block: dict[Sample, Floats]) -> Bools:
        """Which frames fulfil the condition, by their samples."""
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            return self.plan.condition.holds(block)

    def _holds(self, units: _Units, block: dict[Sample, Floats]) -> Bools:
        """Which frames of some units fulfil the condition and are asked for."""
        return self._fulfil(block) & self._there(units)

    def _there(self, units: _Units) -> Bools:
        """Which frames of some units the documents still have, and carry the motion names that are asked for."""
        places, chunks = units.lead.places, units.lead.about[CHUNK_NUMBER]
        found = self._timeline.here(places, chunks)
        if self._labelled is None:
            return found
        positions = self._timeline.positions(places[:, None], slots_of_chunks(chunks))
        named = np.zeros(found.shape, bool)
        for place in np.unique(places).tolist():
            rows = np.flatnonzero(places == place)
            for first, last in self._labelled[self.forest.keys[place]]:
                named[rows] |= (positions[rows] >= first) & (positions[rows] <= last)
        return found & named


@cache
def _places(bits: int, wanted: tuple[int, ...]) -> tuple[Some, Some]:
    """Where the channels that a track has stand among those that are wanted, and where in the track."""
    held = channels_of(bits)
    both = [(place, held.index(channel)) for place, channel in enumerate(wanted) if channel in held]
    here, there = np.array(both, np.int64).reshape(-1, 2).T
    return (evenly(here), evenly(there)) if both else (here, there)


@dataclass(frozen=True)
class _Units:
    """Stretches of up to 256 frames. lead: the leading track of each. others: by name, those of other bones over the
    same frames. must: where each frame of the leading track fulfils the condition, as zone maps tell."""

    lead: Table
    others: dict[str, Table]
    must: Bools

    def __len__(self) -> int:
        return len(self.lead)

    def __getitem__(self, which: Ints | slice) -> _Units:
        others = {name: table[which] for name, table in self.others.items()}
        return _Units(self.lead[which], others, self.must[which])

    def ends(self, sample: Sample) -> Interval:
        name, channel = sample
        return self.others.get(name or "", self.lead).ends(channel, self.lead.about[FRAMES])


@dataclass(frozen=True)
class _Hits:
    """holds: (units, CHUNK), where the condition is fulfilled. lead: the leading track of each unit."""

    holds: Bools
    lead: Table

    @property
    def count(self) -> int:
        return int(np.count_nonzero(self.holds))

    def frames(self, timeline: Timeline) -> tuple[Ints, Ints]:
        """The frames, and for each the bone."""
        unit, offset = np.nonzero(self.holds)
        places, chunks = self.lead.places[unit], self.lead.about[CHUNK_NUMBER, unit]
        positions = timeline.positions(places, chunks * CHUNK + offset)
        frames = (places << DOCUMENT_SHIFT) | (positions << FRAME_SHIFT)
        bones = self.lead.about[BONE, unit]
        if len(frames) > 1 and (np.diff(frames) < 0).any():
            # Frames may have been put into another order than that of their slots.
            order = np.argsort(frames, kind="stable")
            return frames[order], bones[order]
        return frames, bones
