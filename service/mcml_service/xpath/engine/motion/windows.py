"""Count matching frames near a frame, without listing them for each frame.

`frame[following-sibling::frame[position() <= 9][motion_name="walk"]]` compares n frames with about 9 n others. But the
match of each frame is computed once, and the count in a range is a difference of two sums.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mcml_service.xpath.engine.axes import REVERSE
from mcml_service.xpath.language.positions import Window
from mcml_service.xpath.language.tree import Step
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.numbering import DOCUMENT_SHIFT, FRAME_SHIFT, Bools, Ints, documents_of, frames_of
from mcml_service.xpath.nodes.pairs import expand


class Windows:
    """The answer for one step.

    kept: mask of matching frames. For slices of context nodes, the frames of the same documents are read only once.
    """

    def __init__(self, forest: Forest, step: Step, window: Window, kept: Callable[[Ints], Bools]) -> None:
        self._forest = forest
        self._window = window
        self._backwards = step.axis in REVERSE
        self._kept = kept
        self._documents = np.empty(0, np.int64)
        self._starts = np.empty(0, np.int64)
        self._sums = np.zeros(1, np.int64)

    def counts(self, frames: Ints) -> Ints:
        """How many frames count in the window of each frame."""
        documents, index = np.unique(documents_of(frames), return_inverse=True)
        if not np.array_equal(documents, self._documents):
            self._look(documents)
        index = index.reshape(-1)
        start, stop = self._starts[index], self._starts[index + 1]
        own = start + frames_of(frames) - 1
        low, high = self._window
        first, last = (own - high, own - low) if self._backwards else (own + low, own + high)
        first, last = np.clip(first, start, stop), np.clip(last + 1, start, stop)
        return np.asarray(np.maximum(self._sums[np.maximum(first, last)] - self._sums[first], 0), np.int64)

    def _look(self, documents: Ints) -> None:
        counts = self._forest.frames[documents]
        source, position = expand(counts)
        frames = (documents[source] << DOCUMENT_SHIFT) | ((position + 1) << FRAME_SHIFT)
        self._documents = documents
        self._starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        self._sums = np.concatenate([[0], np.cumsum(self._kept(frames))]).astype(np.int64)
