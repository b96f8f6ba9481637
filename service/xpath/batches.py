"""What documents side by side are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from service.errors import StoreError
from service.storage.columns import Listed
from service.xpath.frame_runs import IdRuns, LabelRuns
from service.xpath.head_rows import HeadRows
from service.xpath.layouts import Layout, ShapeRuns
from service.xpath.numbering import MAX_DOCUMENTS, MAX_FRAMES, Ints
from service.xpath.timeline import Timeline
from service.xpath.zones import Table

HEAD_BYTES, FRAME_BYTES = 30_000, 30
"""About how much memory the columns of a document take, and of each of its frames."""


@dataclass
class Batch:
    """The columns of some documents, each as soon as somebody needed it. keys, frames: of each. nbytes: about how much
    all of them take."""

    keys: list[int]
    frames: Ints
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
    frames = np.array([listed.frames for listed in documents], np.int64)
    if len(documents) > MAX_DOCUMENTS or (frames > MAX_FRAMES).any():
        raise StoreError("More documents or frames than nodes can be numbered for.")
    nbytes = HEAD_BYTES * len(documents) + FRAME_BYTES * int(frames.sum())
    return Batch([listed.key for listed in documents], frames, nbytes)
