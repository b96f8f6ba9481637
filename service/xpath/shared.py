"""What the queries of a process keep between them: parts of the store that never change, not answers."""

from __future__ import annotations

from dataclasses import dataclass, field

from service.xpath.heads import Heads
from service.xpath.tracks import Tracks


@dataclass(frozen=True)
class Shared:
    """heads: of documents, as nodes. tracks: decoded."""

    heads: Heads = field(default_factory=Heads)
    tracks: Tracks = field(default_factory=Tracks)
