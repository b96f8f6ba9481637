"""The range of a quantity in a library, for choosing a threshold."""

from __future__ import annotations

import numpy as np

from mcml.motion.bodies.quantities import AskedQuantity
from mcml_schemas.querying.examples import QuantityRange
from mcml_service.actions.suggesting.sample_motion import MotionSample
from mcml_service.clips.frame_quantities import FrameQuantities, is_beside_positions
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.limits import Limits

_SHARES = (0.0, 0.05, 0.5, 0.95, 1.0)


def find_range(tx: Transaction, sample: MotionSample, asked: AskedQuantity, limits: Limits) -> QuantityRange:
    """Return the quantiles of a quantity in a sample; values are read until the time is up."""
    if is_beside_positions(asked):
        found = []
        for listed, body in sample.clips:
            if limits.over:
                break
            values = FrameQuantities(tx, listed, body).read_known(asked)
            found.append(values[~np.isnan(values)])
        found = [values for values in found if len(values)]
    else:
        found = sample.values(asked.name, asked.arguments)
    if not found:
        return QuantityRange(quantity=asked.text, unit=asked.unit, clips=0)
    least, low, middle, high, most = map(float, np.quantile(np.concatenate(found), _SHARES))
    return QuantityRange(
        quantity=asked.text,
        unit=asked.unit,
        clips=len(found),
        least=least,
        low=low,
        middle=middle,
        high=high,
        most=most,
    )
