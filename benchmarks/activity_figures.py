"""Precision and recall of recognised activities, by the names of clips: the table of docs/motion.md.

`python -m benchmarks.activity_figures FOLDER` takes BVH files of the Bandai-Namco-Research-Motiondataset, with their
contents in their names (`dataset-2_walk-turn-left_normal_003.bvh`). A clip has an activity if it is recognised in any
frame.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import mcml

SHOWN: dict[str, Callable[[str], bool]] = {
    "walk": lambda content: content.startswith("walk"),
    "run": lambda content: content in ("run", "dash"),
    "turn left": lambda content: content.endswith("turn-left"),
    "turn right": lambda content: content.endswith("turn-right"),
    "wave": lambda content: content.startswith(("wave", "bye")),
    "raise hand": lambda content: content.startswith("raise-up"),
}
"""Whether clips of a content, the second part of their names, show an activity."""
UNSAID = ("dance", "kick", "punch", "slash")
"""Contents that may hold any of them."""


def main() -> None:
    """Print a row for each activity."""
    files = [file for file in sorted(Path(sys.argv[1]).rglob("*.bvh")) if not content_of(file).startswith(UNSAID)]
    with ProcessPoolExecutor() as pool:
        found = dict(zip(files, pool.map(names_in, files, chunksize=8), strict=True))
    print(f"{len(files)} clips\n\n| activity | clips that show it | precision | recall |\n|---|---|---|---|")
    for name, shows in SHOWN.items():
        wanted = {file for file in files if shows(content_of(file))}
        got = {file for file, names in found.items() if any(set(name.split()) <= set(one.split()) for one in names)}
        both = len(wanted & got)
        print(f"| {name} | {len(wanted)} | {both / max(len(got), 1):.3f} | {both / max(len(wanted), 1):.3f} |")


def content_of(file: Path) -> str:
    """The content of a clip, from its name."""
    return file.name.split("_")[1]


def names_in(file: Path) -> set[str]:
    """The activities of a clip."""
    return {activity.name for activity in mcml.read(file).activities()}


if __name__ == "__main__":
    main()
