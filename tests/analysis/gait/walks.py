"""Trials of walkers whose gait is known."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import mcml
from mcml.laboratory.gait_trials import Trial
from mcml.laboratory.measure_gait import EventSource
from tests.laboratory.walkers import Gait, events_of, make_c3d


@dataclass
class Walk:
    """A `TrialSource`. walker: None for a clip without gait."""

    document: str
    walker: Gait | None
    properties: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    measured: int = 0

    def measure(self, source: EventSource) -> Trial:
        self.measured += 1
        name = f"walk {self.document}"
        if self.walker is None:
            return Trial(self.document, name, None, {}, ("it has no feet",))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "walk.c3d")
            path.write_bytes(make_c3d(self.walker, events_of(self.walker)))
            gait = mcml.read(path).measure_gait(source)
        return Trial(self.document, name, gait, {}, gait.warnings)
