"""Sets of markers, and words of markers, with their landmarks.

`sets.csv` has a column for each set; a cell names the set's markers at a landmark, apart by `|`. `words.csv` has words
without a side. Landmarks are anatomical places (`left_asis`), centres of joints (`left_knee_centre`), or `…_tracking`
for markers that only follow a segment.
"""

from __future__ import annotations

import csv
import re
import unicodedata
from collections import defaultdict
from functools import cache

from mcml.resources import landmark_sets_path, landmark_words_path

KEY_POINTS = frozenset({"openpose-body25", "halpe-26", "coco-17", "mediapipe-33", "opencap"})
"""Sets of cameras, whose points are centres of joints."""


def key_of(marker: str) -> str:
    """Return the part of a marker's name that is compared: lower-case letters and digits."""
    return re.sub(r"[\s_.()\-]+", "", unicodedata.normalize("NFKC", marker)).lower()


@cache
def marker_sets() -> dict[str, dict[str, str]]:
    """Set → key of a marker → landmark."""
    sets: dict[str, dict[str, str]] = defaultdict(dict)
    with landmark_sets_path().open(encoding="utf-8", newline="") as stream:
        for row in csv.DictReader(stream):
            landmark = row.pop("landmark")
            for name, markers in row.items():
                for marker in filter(None, markers.split("|")):
                    sets[name][key_of(marker)] = landmark
    return dict(sets)


@cache
def agreed_landmarks() -> dict[str, str]:
    """Key of a marker → the landmark on which all sets of markers agree that have it."""
    every: dict[str, set[str]] = defaultdict(set)
    for name, markers in marker_sets().items():
        if name not in KEY_POINTS:
            for key, landmark in markers.items():
                every[key].add(landmark)
    return {key: next(iter(landmarks)) for key, landmarks in every.items() if len(landmarks) == 1}


@cache
def marker_words() -> dict[str, str]:
    """Word of a marker → landmark without a side."""
    with landmark_words_path().open(encoding="utf-8", newline="") as stream:
        return {word: row["landmark"] for row in csv.DictReader(stream) for word in row["words"].split()}
