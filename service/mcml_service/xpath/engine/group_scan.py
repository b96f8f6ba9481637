"""A plan run over one group of documents: tracks that zone maps rule out are skipped, the others looked at together."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mcml.language.vocabulary import FRAME, FRAME_BONE
from mcml_service.storage.core.schema import CHUNK
from mcml_service.xpath.engine.axes import step as axis_step
from mcml_service.xpath.engine.columns import Columns
from mcml_service.xpath.engine.samples.kernel import fulfilled
from mcml_service.xpath.engine.samples.stacked import Some, StackedBones
from mcml_service.xpath.engine.scan_plan import ScanPlan
from mcml_service.xpath.language.conditions import Sample, sample
from mcml_service.xpath.language.tree import Variable
from mcml_service.xpath.library.bone_columns import summary
from mcml_service.xpath.library.forest import Bone, Forest
from mcml_service.xpath.library.intervals import Interval
from mcml_service.xpath.library.track_values import MOST_TRACKS, track_values
from mcml_service.xpath.library.zones import BONE, CHUNK_NUMBER, FRAMES, Table
from mcml_service.xpath.nodes.numbering import DOCUMENT_SHIFT, FRAME_SHIFT, Bools, Floats, Ints
from mcml_service.xpath.nodes.pairs import rows_and_columns
from mcml_service.xpath.nodes.timeline import Timeline, slots_of_chunks

FIRST_UNITS = 128
"""Often the first page is all that is wanted."""
UNITS = 2048
"""Tracks of the leading bone that are looked at together: half a million samples a channel."""
MANY_TRACKS = 1024
"""Number of tracks in a group from which all bones are counted together."""
FEW = 6
"""One of this many tracks is decoded alone rather than all together."""

Ranges = dict[int, list[tuple[int, int]]]
Block = dict[Variable, Floats]


class GroupScan:
    """labelled: queried frame ranges of each document, None for all. check: called often; raises when time is up."""

    def __init__(self, forest: Forest, plan: ScanPlan, labelled: Ranges | None, check: Callable[[], None]) -> None:
        self.forest = forest
        self.plan = plan
        self.tracks_read = 0
        self._labelled = labelled
        self._check = check
        self._columns = Columns(forest, check)

    @property
    def lead(self) -> Table:
        """The tracks that are looked through."""
        return self._bones[self.plan.lead].table

    @property
    def is_ready(self) -> bool:
        """Whether the zone maps for the condition are cached."""
        return all(self.forest.has_bone(name) for name in self._names)

    def ends(self, sample: Sample) -> Bone:
        return self._bones[self.plan.lead if sample.bone is None else sample.bone]

    def most(self, sample: Sample, sign: float) -> float:
        """The greatest sample of a channel (sign 1), or the least one's negative (-1); minus infinity for none."""
        held = self.ends(sample)
        found = float((held.greatest if sign > 0 else -held.least)[sample.channel])
        return found if found == found else -np.inf

    def nodes(self) -> Iterator[Ints]:
        """The nodes of the answer in order, some at a time."""
        for hits in self._hits(self._units()):
            nodes = self._targets(hits)
            if len(nodes):
                yield nodes

    def count(self) -> int:
        """Return the number of nodes."""
        if self._stacked is not None:
            return self._stacked_count(self._stacked)
        if not self.plan.one_each:
            return sum(len(nodes) for nodes in self.nodes())
        units = self._units()
        lead = self._bones[self.plan.lead]
        if self._labelled is None and len(lead) <= MOST_TRACKS and 2 * np.count_nonzero(~units.must) > len(lead):
            # Most tracks must be compared, so all are compared in stored order, without selection and sorting.
            self.tracks_read += len(lead)
            block = {sample: found for name in self._names for sample, found in self._side_by_side(name).items()}
            return int(np.count_nonzero(self._fulfil(block) & self.forest.here(self.plan.lead)))
        return sum(hits.count for hits in self._hits(units))

    def totals(self, sample: Sample) -> tuple[float, int]:
        """Return the sum of a channel over all hits, and their number.

        Sums of tracks in which all frames are hits are cached.
        """
        columns = self.ends(sample)
        known = self.plan.condition.is_presence and self._labelled is None
        if known and (found := columns.total(sample.channel)) is not None:
            return found
        units = self._units()
        whole = np.zeros(len(units), bool)
        total = count = 0.0
        if sample.bone in (None, self.plan.lead):
            whole = units.must & self._whole(units)
        if whole.any():
            sums = columns.sums(sample.channel, lambda table: self._sums(sample.bone, table, sample.channel))
            total = float(sums[units.numbers[whole]].sum())
            count = float(units.lead.about[FRAMES][whole].sum())
        for some in self._parts(units[np.flatnonzero(~whole)]):
            block = self._read(some)
            values = block[sample][self._holds(some, block)]
            total, count = total + float(values.sum()), count + len(values)
        if known:
            columns.keep_total(sample.channel, (total, int(count)))
        return total, int(count)

    def most_of_hits(self, sample: Sample, sign: float, best: float) -> float:
        """The greatest number of a channel (sign 1), or the least one's negative (-1), among the hits; `best`, where
        that is greater.

        Of tracks all of whose frames are hits, zone maps tell it; others are read while they may hold a greater one.
        """
        if self.most(sample, sign) <= best:
            return best
        units = self._units()
        ends = units.ends(sample)
        most = ends.high if sign > 0 else -ends.low
        whole = units.must & self._whole(units)
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
        return best

    @cached_property
    def _names(self) -> list[str | None]:
        """The leading bone first."""
        others = {each.bone for each in self.plan.condition.samples if each.bone is not None} - {self.plan.lead}
        return [self.plan.lead, *sorted(others)]

    @cached_property
    def _bones(self) -> dict[str | None, Bone]:
        self._check()
        return {name: self.forest.bone(name) for name in self._names}

    @cached_property
    def _stacked(self) -> StackedBones | None:
        """All bones side by side, where hits are counted so."""
        plan = self.plan
        if not plan.any_bone or self._labelled is not None or len(self.lead) < MANY_TRACKS:
            return None
        if plan.attribute not in (None, "id") or (plan.target == FRAME_BONE and not plan.one_each):
            return None
        bones = StackedBones(self._columns)
        return bones if bones.takes(plan.condition) else None

    def _stacked_count(self, bones: StackedBones) -> int:
        total = 0
        for stack, here in zip(bones.stacks.stacks, bones.stacks.here(self._timeline), strict=True):
            self._check()
            holds = bones.truth(self.plan.condition, Some(stack))
            if self.plan.target == FRAME:
                holds = np.logical_or.reduce(holds, axis=0)
            total += int(np.count_nonzero(holds if here is None else holds & here))
        self.tracks_read += bones.tracks_read
        return total

    @cached_property
    def _timeline(self) -> Timeline:
        return self.forest.timeline

    def _targets(self, hits: _Hits) -> Ints:
        plan = self.plan
        frames, bones = hits.frames(self._timeline)
        nodes = np.unique(frames) if plan.any_bone and plan.target == FRAME else frames
        if plan.target == FRAME_BONE and plan.any_bone:
            nodes = np.sort(self.forest.shapes.numbered(frames, bones))
        elif plan.target == FRAME_BONE:
            shapes = self.forest.shapes
            nodes = shapes.children(frames)[1] if plan.bone is None else shapes.named(frames, plan.bone)[1]
        return nodes if plan.attribute is None else axis_step(self.forest, nodes, "attribute", plan.attribute)[1]

    def _hits(self, units: _Units) -> Iterator[_Hits]:
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

    def _units(self) -> _Units:
        """The leading tracks that may hold a hit, in the order of their frames."""
        condition, lead = self.plan.condition, self._bones[self.plan.lead]
        others = {name: bone.facing(lead) for name, bone in self._bones.items() if name != self.plan.lead}
        units = _Units(lead.table, others, np.zeros(len(lead), bool), np.arange(len(lead)))
        verdict = condition.judge({sample: units.ends(sample) for sample in condition.samples})
        order = np.flatnonzero(verdict.may)
        if self.plan.any_bone:
            about, places = lead.table.about, lead.table.places
            order = order[np.lexsort((*about[[BONE, CHUNK_NUMBER]][:, order], places[order]))]
        return _Units(lead.table, others, verdict.must, units.numbers)[order]

    def _read(self, units: _Units) -> Block:
        """The samples that the condition reads, (units, CHUNK), NaN where a frame has none."""
        self.tracks_read += len(units)
        block: Block = {}
        lead = self._bones[self.plan.lead]
        beside = len(lead) <= MOST_TRACKS and len(units) * FEW >= len(lead)
        for name in self._names:
            if beside:
                block |= {sample: found[units.numbers] for sample, found in self._side_by_side(name).items()}
            else:
                wanted = self._channels(name)
                values = track_values(self.forest, units.lead if name == self.plan.lead else units.others[name], wanted)
                block |= {sample(name, channel): found for channel, found in zip(wanted, values, strict=True)}
        return block

    def _channels(self, name: str | None) -> tuple[int, ...]:
        """Those of a bone that the condition reads."""
        return tuple(sorted(each.channel for each in self.plan.condition.samples if each.bone == name))

    def _side_by_side(self, name: str | None) -> Block:
        """The samples of a bone in all tracks of the leading bone, or over the same frames: channels that are not kept
        are read together."""
        bone, wanted = self._bones[name], self._channels(name)
        missing = tuple(each for each in wanted if not self.forest.has_samples(name, each))
        found: Sequence[Floats] = list(track_values(self.forest, bone.table, missing)) if missing else []
        read = dict(zip(missing, found, strict=True))
        lead = self._bones[self.plan.lead]
        block: Block = {}
        for channel in wanted:
            values = self._samples(name, bone.table, channel, read.get(channel))
            block[sample(name, channel)] = values if bone is lead else bone.over(lead, values)
        return block

    def _samples(self, name: str | None, table: Table, channel: int, read: Floats | None = None) -> Floats:
        """(tracks, CHUNK): the samples of a bone in all of its tracks. read: where they were read already."""

        def values() -> Floats:
            return np.asarray(track_values(self.forest, table, (channel,))[0] if read is None else read, np.float64)

        return self.forest.samples(name, channel, values)

    def _sums(self, name: str | None, table: Table, channel: int) -> Floats:
        if self.forest.has_samples(name, channel):
            return np.asarray(np.nansum(self._samples(name, table, channel), axis=1))
        parts = []
        for start in range(0, len(table), UNITS):
            self._check()
            parts.append(np.nansum(track_values(self.forest, table[start : start + UNITS], (channel,))[0], axis=1))
        return np.concatenate([*parts, np.empty(0)])

    def _fulfil(self, block: Block) -> Bools:
        """Which frames fulfil the condition, by their samples."""
        return fulfilled(self._columns, self.plan.condition.tree, block)

    def _holds(self, units: _Units, block: Block) -> Bools:
        """Tell which frames of some units fulfil the condition and are in the query."""
        return self._fulfil(block) & self._there(units)

    def _there(self, units: _Units) -> Bools:
        """Tell which frames of some units still exist and have the queried motion names."""
        places, chunks = units.lead.places, units.lead.about[CHUNK_NUMBER]
        lead = self._bones[self.plan.lead]
        if len(lead) <= MOST_TRACKS:
            found = self.forest.here(self.plan.lead)[units.numbers]
        else:
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

    def _whole(self, units: _Units) -> Bools:
        """Tell of which units every frame is queried."""
        lead = self._bones[self.plan.lead]
        if self._labelled is None and len(lead) <= MOST_TRACKS:
            return self.forest.whole(self.plan.lead)[units.numbers]
        return np.asarray(self._there(units).sum(axis=1) == units.lead.about[FRAMES])


def part_ends(parts: Sequence[GroupScan], sample: Sample) -> Interval:
    """Return the range of the samples of a channel in each of several groups."""
    return summary([part.ends(sample) for part in parts], sample.channel)


@dataclass(frozen=True)
class _Units:
    """Ranges of up to 256 frames.

    lead: the leading track of each. others: tracks of other bones over the same frames, by name. must: where each frame
    of the leading track fulfils the condition, from zone maps. numbers: of the leading tracks among all.
    """

    lead: Table
    others: dict[str | None, Table]
    must: Bools
    numbers: Ints

    def __len__(self) -> int:
        return len(self.lead)

    def __getitem__(self, which: Ints | slice) -> _Units:
        others = {name: table[which] for name, table in self.others.items()}
        return _Units(self.lead[which], others, self.must[which], self.numbers[which])

    def ends(self, sample: Sample) -> Interval:
        return self.others.get(sample.bone, self.lead).ends(sample.channel, self.lead.about[FRAMES])


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
        unit, offset = rows_and_columns(self.holds)
        places, chunks = self.lead.places[unit], self.lead.about[CHUNK_NUMBER, unit]
        positions = timeline.positions(places, chunks * CHUNK + offset)
        frames = (places << DOCUMENT_SHIFT) | (positions << FRAME_SHIFT)
        bones = self.lead.about[BONE, unit]
        if len(frames) > 1 and (np.diff(frames) < 0).any():
            # Frames may have been put into another order than that of their slots.
            order = np.argsort(frames, kind="stable")
            return frames[order], bones[order]
        return frames, bones
