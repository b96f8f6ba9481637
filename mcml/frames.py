"""Frames as an array that knows its columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np


class Frames(np.ndarray):
    """An array of frames: (frames, columns) of channels, or (frames, bones, 3 or 4) of positions or rotations.

    columns: labels of the second axis: BONE.CHANNEL, or bones. times: (frames,) seconds from the first frame, NaN where
    the rate is unknown. ids: of the frames. units: of the columns, for quantities of the body; "" for channels. Results
    of NumPy functions are plain arrays without these attributes.
    """

    columns: list[str]
    times: np.ndarray
    ids: list[str]
    units: list[str]

    @classmethod
    def of(
        cls, values: np.ndarray, columns: list[str], times: np.ndarray, ids: list[str], units: Sequence[str] = ()
    ) -> Frames:
        """Return the values with their labels."""
        made = np.asarray(values).view(cls)
        made.columns, made.times, made.ids, made.units = columns, times, ids, list(units)
        return made

    def __array_finalize__(self, made_of: Any) -> None:
        self.columns, self.times, self.ids, self.units = [], np.empty(0), [], []

    def __array_wrap__(self, made: np.ndarray, context: Any = None, return_scalar: bool = False) -> Any:
        return made[()] if return_scalar else np.asarray(made)

    def __getitem__(self, key: Any) -> Any:
        return np.asarray(self)[key]

    def to_pandas(self) -> Any:
        """A DataFrame with a column for each number and the times as index. Needs pandas."""
        import pandas as pd

        columns = self.columns
        if self.ndim == 3:
            columns = [f"{bone}.{part}" for bone in columns for part in "xyzw"[: self.shape[2]]]
        index = pd.Index(self.times, name="seconds")
        return pd.DataFrame(np.asarray(self).reshape(len(self), -1), index=index, columns=columns)
