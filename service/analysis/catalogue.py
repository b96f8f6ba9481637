"""Every analysis that users may run, by subject and verb: `mcml analyse reach fit`."""

from __future__ import annotations

from collections.abc import Mapping

from service.analysis.interface import Analysis

SUBJECTS: Mapping[str, Mapping[str, Analysis]] = {}

ANALYSES: Mapping[str, Analysis] = {
    analysis.name: analysis for verbs in SUBJECTS.values() for analysis in verbs.values()
}
"""By name."""
