"""Bodies that follow paths by the program's rules, for the studio's own."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from mcml.motion.edits.splicing import decay
from mcml.motion.matching.following import follow
from mcml.motion.matching.library import ROWS_AHEAD, MatchingLibrary
from mcml.motion.matching.paths import Path
from mcml.motion.matching.tracks import RATE
from tests.motion.matching.curved_walks import curved_walk, track_of_clip

TURNS = (0.0, 40.0, -40.0, 80.0, -80.0)
PATHS = {
    "line": [[0, 0], [6, 0]],
    "corner": [[1, 2], [4, 2], [4, 6]],
    "circle": [[2.5 * np.sin(a), 2.5 - 2.5 * np.cos(a)] for a in np.linspace(0, 2 * np.pi, 60)],
}


def cases() -> dict[str, Any]:
    """facts, rows: of a library. paths: points, the runs along them, and how far the body was from them. decays: of
    values and speeds."""
    tracks = [track_of_clip(curved_walk(turn, 4.0, heading=31.0 * at)) for at, turn in enumerate(TURNS)]
    library = MatchingLibrary.of(tracks)
    starts = library.starts.tolist()
    columns = (library.features, library.place, library.facing[:, None], library.targets[:, None])
    rows = np.concatenate(columns, axis=1).astype("<f4")
    facts = {
        "rate": RATE,
        "rows": len(library),
        "up": "Y",
        "axes": "ZX",
        "scales": library.scales.tolist(),
        "ahead": list(ROWS_AHEAD),
        "speed": library.usual_speed,
        "clips": [
            {
                "document": f"clip {at}",
                "revision": 1,
                "name": "",
                "first": first,
                "last": end - 1,
                "frames": 240,
                "seconds_per_frame": track.frame_time,
                "skipped": 0,
                "metres": 0.01,
            }
            for at, (track, first, end) in enumerate(zip(tracks, starts, starts[1:], strict=False))
        ],
        "left_out": [],
    }
    rng = np.random.default_rng(7)
    values, speeds = rng.normal(size=(2, 40)) * [[1.0], [0.2]]
    return {
        "facts": facts,
        "rows": base64.b64encode(rows.tobytes()).decode(),
        "paths": {name: _followed(library, np.array(points, float)) for name, points in PATHS.items()},
        "decays": {"values": values.tolist(), "speeds": speeds.tolist(), "frames": decay(values, speeds, 9).tolist()},
    }


def _followed(library: MatchingLibrary, points: np.ndarray) -> dict[str, Any]:
    made = follow(library, Path.through(points), speed=1.2, steering=np.radians(10.0))
    starts = library.starts
    return {
        "points": points.tolist(),
        "runs": [[int(starts[run.clip]) + run.first, int(starts[run.clip]) + run.last] for run in made.runs],
        "angles": [run.angle for run in made.runs],
        "places": made.places.tolist(),
        "distances": made.distances.tolist(),
    }
