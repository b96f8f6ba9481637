"""Loaded samples: identified by their values, not by the number of their node."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import orjson

from mcml_service.xpath.nodes.numbering import Bools, Floats, Ints
from mcml_service.xpath.nodes.texts import Strings


@dataclass(frozen=True, slots=True)
class Samples:
    """For each context a node set of one sample, or an empty one where `numbers` is NaN: only its value is used."""

    numbers: Floats

    def __len__(self) -> int:
        return len(self.numbers)

    def __getitem__(self, which: Ints | Bools) -> Samples:
        return Samples(self.numbers[which])

    @property
    def exist(self) -> Bools:
        return ~np.isnan(self.numbers)

    def equal(self, other: Samples) -> Bools:
        """Which are equal as strings: those whose bits are, so 0.0 and -0.0 are not."""
        one, two = self.numbers, other.numbers
        return np.asarray((one == two) & (np.signbit(one) == np.signbit(two)), bool)


def sample_texts(numbers: Floats) -> Strings:
    """The strings of samples: of each the shortest that gives its bits."""
    # As bits, for 0.0 and -0.0 are two strings.
    bits, codes = np.unique(np.ascontiguousarray(numbers).view(np.int64), return_inverse=True)
    text = orjson.dumps(bits.view(np.float64), option=orjson.OPT_SERIALIZE_NUMPY).decode()
    return Strings(codes.reshape(-1).astype(np.int64), text[1:-1].split(",") if len(bits) else [])
