"""What documents side by side are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from service.storage.columns import Listed
from service.xpath.frame_runs import IdRuns, LabelRuns
from service.xpath.head_rows import HeadRows
from service.xpath.layouts import Layout, ShapeRuns
from service.xpath.timeline import Timeline
from service.xpath.zones import Table

HEAD_BYTES, FRAME_BYTES = 30_000, 30
"""About how much memory the columns of a document take, and of each of its frames."""


@dataclass
class Batch:
    """The columns of some documents, each as soon as somebody needed it. nbytes: about how much all of them take."""

    nbytes: int
    head: HeadRows | None = None
    layouts: list[Layout] | None = None
    shapes: ShapeRuns | None = None
    labels: LabelRuns | None = None
    ids: IdRuns | None = None
    timeline: Timeline | None = None
    tracks: Table | None = None


def batch_of(documents: Sequence[Listed]) -> Batch:
    """Nothing of the columns of some documents yet."""
    return Batch(HEAD_BYTES * len(documents) + FRAME_BYTES * sum(listed.frames for listed in documents))
