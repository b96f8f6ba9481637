"""Reports of edits of frames: decisions as sentences, replaced samples, and the first frame that is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from mcml.motion.clip import FrameBlock
from mcml.motion.skeleton import CHANNELS
from mcml.numerics.runs import find_true
from mcml_service.storage.documents.timelines import Run
from mcml_service.storage.documents.tracks import Piece
from mcml_service.storage.undo.frame_pairs import compose_pairs, pair_frames


@dataclass
class Replacement:
    """New samples of a bone. ranges: frames (positions from 1, both included). changes: samples by channel, and the sum
    of their differences, in the unit of the channel, from samples that were known.
    """

    ranges: list[tuple[int, int]] = field(default_factory=list)
    changes: dict[str, tuple[int, float]] = field(default_factory=dict)

    @property
    def frames(self) -> int:
        return sum(last - first + 1 for first, last in self.ranges)

    @property
    def channels(self) -> list[str]:
        """Channels with the most new samples first, then with the largest differences."""
        return sorted(self.changes, key=self.changes.__getitem__, reverse=True)


@dataclass
class EditReport:
    """notes: sentences, such as a chosen cut-off. replaced: of filled or despiked bones, by name. first_kept: frame of
    the document before that is frame 1 after `keep` or `loop`; None after other edits. kept: frames that the document
    has before and after the edits; None: they are not followed.
    """

    notes: list[str] = field(default_factory=list)
    replaced: dict[str, Replacement] = field(default_factory=dict)
    first_kept: int | None = None
    kept: list[Run] | None = None

    def follow(self, before: list[Piece], after: list[Piece], *, loop: bool = False) -> None:
        """Follow frames over one more edit. before, after: the timelines. loop: all frames are new, from `first_kept`
        on."""
        if self.kept is None:
            return
        step = pair_frames(before, after)
        if loop and self.first_kept is not None:
            step = [Run(self.first_kept, 1, sum(piece.count for piece in after))]
        self.kept = compose_pairs(self.kept, step)

    def add_replaced(self, names: Sequence[str], before: FrameBlock, after: FrameBlock, first: int) -> None:
        """Add the samples that differ.

        names: of the joints of both blocks, which have the same columns. first: position of their first frame.
        """
        differs = ~((before.values == after.values) | (np.isnan(before.values) & np.isnan(after.values)))
        counts = differs.sum(axis=0)
        sums = np.nansum(np.abs(after.values - before.values), axis=0)
        columns: dict[int, list[int]] = {}
        for index in np.flatnonzero(counts).tolist():
            columns.setdefault(before.columns[index][0], []).append(index)
        for joint, own in columns.items():
            known = self.replaced.setdefault(names[joint], Replacement())
            ranges = find_true(differs[:, own].any(axis=1)).tolist()
            known.ranges.extend((first + start, first + stop - 1) for start, stop in ranges)
            for index in own:
                channel = CHANNELS[before.columns[index][1]]
                count, change = known.changes.get(channel, (0, 0.0))
                known.changes[channel] = count + int(counts[index]), change + float(sums[index])
