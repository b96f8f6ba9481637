"""The centre of a hip from the spines of the pelvis, for landmark sets without measures of the legs.

Source: Harrington, Zavatsky, Lawson, Yuan and Theologis 2007 ("Prediction of the hip joint centre in adults, children,
and patients with cerebral palsy based on magnetic resonance imaging").
"""

from __future__ import annotations

import numpy as np

from mcml.laboratory.gait_model.lower_body import SIGNS
from mcml.motion.skeleton import Array


def harrington_hip(side: str, width: float, depth: float) -> Array:
    """(3,) millimetres of a hip centre in the pelvis, from the middle of the front spines.

    width: between the front spines. depth: from their middle to the middle of the back spines.
    """
    return np.array([-0.24 * depth - 9.9, SIGNS[side] * (0.33 * width + 7.3), -0.30 * width - 10.9])
