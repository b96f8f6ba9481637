"""Origins of calibration values."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a value came from. kind: "stated" (by the file), "measured" (it follows from the skeleton and the frames),
    "guessed", "set" (by people) or "unknown". reason: for people."""

    kind: str
    reason: str = ""
