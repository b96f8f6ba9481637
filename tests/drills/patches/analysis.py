"""How far roots travel."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mcml_schemas.analyses.travel import TravelParameters

from mcml_service.analysis.interface import Analysis, Motion, Part, PartInfo, Parts, Progress


def run(motions: Sequence[Motion], parameters: TravelParameters, progress: Progress) -> Parts:
    """The way of each root, in the clip's unit."""
    rows = []
    for number, motion in enumerate(motions, 1):
        steps = np.linalg.norm(np.diff(motion.translations[:: parameters.step, 0], axis=0), axis=1)
        rows.append([motion.name, float(steps.sum())])
        progress("measuring", number / len(motions))
    return {"ways": Part("table", {"columns": ["clip", "way"], "rows": rows})}


TRAVEL = Analysis(
    name="travel",
    title="Travel",
    description="How far the roots of clips travel.",
    parameters=TravelParameters,
    parts={"ways": PartInfo("table", "The way of each clip")},
    run=run,
)
