"""Every analysis that users may run, by subject and verb: `mcml analyse reach fit`."""

from __future__ import annotations

from collections.abc import Mapping

from mcml_service.analysis.dance.analyses import BEATS, DANCE, MOTION_GRAPH
from mcml_service.analysis.expression_space.analyses import EXPRESSION
from mcml_service.analysis.gait.analyses import GAIT
from mcml_service.analysis.interface import Analysis
from mcml_service.analysis.reach_blending.analyses import REACH

SUBJECTS: Mapping[str, Mapping[str, Analysis]] = {
    "reach": {"fit": REACH},
    "dance": {"beats": BEATS, "graph": MOTION_GRAPH, "make": DANCE},
    "expression": {"build": EXPRESSION},
    "gait": {"measure": GAIT},
}

ANALYSES: Mapping[str, Analysis] = {
    analysis.name: analysis for verbs in SUBJECTS.values() for analysis in verbs.values()
}
"""By name."""
