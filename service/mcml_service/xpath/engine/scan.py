"""Queries about samples over the documents of a scope, group by group: zone maps first, then whole tracks at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.engine.group_scan import GroupScan, part_ends
from mcml_service.xpath.engine.scan_plan import ScanPlan
from mcml_service.xpath.language.conditions import Sample
from mcml_service.xpath.language.labels import ranges_of
from mcml_service.xpath.language.reach import HeadPart
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.listing import Scope
from mcml_service.xpath.nodes.numbering import Floats, Ints


class Scan:
    """Runs a plan over documents, given in groups in order of the answer. head_part: as of `ColumnSource`."""

    def __init__(
        self,
        tx: Transaction,
        plan: ScanPlan,
        scope: Scope,
        caches: Caches,
        check: Callable[[], None] = lambda: None,
        head_part: HeadPart = HeadPart.MOTION,
    ) -> None:
        self.plan = plan
        groups = scope.groups()
        labelled = None
        if plan.names:
            labelled = ranges_of(tx, plan.names, [key for group in groups for key in group.keys])
            groups = scope.groups([listed for group in groups for listed in group if listed.key in labelled])
        forests = [Forest(tx, group, caches, head_part=head_part) for group in groups]
        self._parts = [GroupScan(forest, plan, labelled, check) for forest in forests]

    @property
    def documents(self) -> Sequence[Listed]:
        """The documents that are read."""
        return [listed for part in self._parts for listed in part.forest.documents]

    @property
    def tracks_read(self) -> int:
        """How many tracks of the leading bone were decoded."""
        return sum(part.tracks_read for part in self._parts)

    def all_tracks(self) -> int:
        """The number of tracks of the leading bone, including those excluded by zone maps."""
        return sum(len(part.lead) for part in self._parts)

    def chunks(self) -> Iterator[tuple[Forest, Ints]]:
        """The nodes of the answer in order, some at a time."""
        for part in self._promising():
            for nodes in part.nodes():
                yield part.forest, nodes

    def count(self) -> int:
        """How many nodes the answer has."""
        return sum(part.count() for part in self._promising())

    def totals(self, sample: Sample) -> tuple[float, int]:
        """Return the sum of the queried channel over all hits, and their number."""
        found = [part.totals(sample) for part in self._promising()]
        return math.fsum(total for total, _ in found), sum(count for _, count in found)

    def extremes(self, sample: Sample, *, greatest: bool) -> Iterator[Floats]:
        """Return the greatest (or least) number of that channel, if there is any."""
        sign = 1.0 if greatest else -1.0
        best = -np.inf
        # Where the greatest may be, first: of most groups nothing is read then.
        for part in sorted(self._promising(), key=lambda part: -part.most(sample, sign)):
            best = part.most_of_hits(sample, sign, best)
        if best > -np.inf:
            yield np.array([sign * best])

    def _promising(self) -> Iterable[GroupScan]:
        """Yield the groups in which a frame may fulfil the condition, as far as is known without reading."""
        known = [part for part in self._parts if part.is_ready]
        if not known:
            return self._parts
        condition = self.plan.condition
        verdict = condition.judge({sample: part_ends(known, sample) for sample in condition.samples})
        refuted = {id(part) for part, may in zip(known, verdict.may.tolist(), strict=True) if not may}
        return [part for part in self._parts if id(part) not in refuted]
