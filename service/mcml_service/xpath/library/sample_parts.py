"""The stored form of the samples of a channel of many tracks: without the padding of short tracks."""

from __future__ import annotations

from typing import Any

import numpy as np

from mcml_service.storage.core.schema import CHUNK
from mcml_service.xpath.nodes.numbering import Floats
from mcml_service.xpath.nodes.stored import Columns


def columns(samples: Floats) -> dict[str, Any]:
    """Of (tracks, CHUNK) samples, NaN where missing."""
    there = ~np.isnan(samples)
    lengths = np.where(there.any(axis=1), CHUNK - there[:, ::-1].argmax(axis=1), 0).astype(np.int16)
    return {"lengths": lengths, "samples": samples[np.arange(CHUNK) < lengths[:, None]]}


def samples_of(found: Columns) -> Floats:
    """The samples that had these columns."""
    lengths = found["lengths"]
    samples = np.full((len(lengths), CHUNK), np.nan)
    samples[np.arange(CHUNK, dtype=np.int16) < lengths[:, None]] = found["samples"]
    return samples
