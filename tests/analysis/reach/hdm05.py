"""Reaches of HDM05 as analyses get them: real clips without age or height, to a low and to a high target."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from mcml.formats import FORMATS
from mcml.formats.format import ReadOptions, SourceFile
from mcml.motion.conventions.convert import convert
from mcml.motion.hub import HubReader
from mcml.motion.skeleton import Convention
from mcml.motion.units import UNITS, reading_of
from mcml_service.analysis.interface import Motion
from tests.builders import assign

TARGETS = {"depositFloorR": "0", "grabHighR": "1"}
RATE = 120
INCHES = UNITS["inch"] / 0.45
"""Metres of a value."""


def read_reaches(folder: Path) -> list[Motion]:
    """The clips of the folder `hdm05_reach`; property target: 0 the floor, 1 high; subject: the actor."""
    found = []
    for amc in sorted(folder.glob("*.amc")):
        match = re.match(r"HDM_(..)_(depositFloorR|grabHighR)_", amc.stem)
        if match is None:
            continue
        asf = folder / f"HDM_{match[1]}.asf"
        with asf.open("rb") as skeleton, amc.open("rb") as motion:
            files = {"asf": SourceFile(asf.name, skeleton), "amc": SourceFile(amc.name, motion)}
            clip = convert(FORMATS["asf-amc"].read(files, ReadOptions()), Convention.LISTED)
            hub = HubReader(clip.head.skeleton, reading_of(clip.head))
            blocks = [hub.read(block) for block in clip.blocks()]
        found.append(
            Motion(
                document=amc.stem,
                revision=1,
                name=amc.stem,
                skeleton=assign(clip.head.skeleton),
                frame_time=1 / RATE,
                rotations=np.concatenate([block.rotations for block in blocks]),
                translations=np.concatenate([block.translations for block in blocks]),
                metres=INCHES,
                up="Y",
                properties={"target": (TARGETS[match[2]], ""), "subject": (match[1], "")},
            )
        )
    return found
