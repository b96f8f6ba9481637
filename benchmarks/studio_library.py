"""What the studio's benchmark looks at: libraries of many short clips, and long clips of a body with fingers."""

from __future__ import annotations

import io
import itertools
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mcml.files.import_options import ImportOptions, Label
from mcml.formats import FORMATS
from mcml.formats.format import SourceFile
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.demo import body
from mcml_service.settings import Settings
from mcml_service.storage.database import Database

KINDS = 100
"""Clips that differ; each is stored many times, so that a large library is there in minutes."""
AT_ONCE = 128
LONG_SECONDS, LONG_RATE = 600, 120


def library(documents: int) -> Path:
    """A store of so many clips of 1 to 3 s; made once a machine, kept in the folder for temporary files."""
    path = Path(tempfile.gettempdir()) / f"mcml-studio-{documents}" / "store.db"
    if path.is_file():
        return path
    path.parent.mkdir(exist_ok=True)
    unfinished = path.with_name("unfinished.db")
    unfinished.unlink(missing_ok=True)
    database = Database(f"sqlite:///{unfinished}")
    database.migrate()
    kinds = list(_kinds())
    for number in range(-(-documents // AT_ONCE)):
        name, content = kinds[number % KINDS]
        count = min(AT_ONCE, documents - number * AT_ONCE)
        # A blank line more each: equal motion, another file.
        files = [
            SourceFile(f"{name}_{number * AT_ONCE + copy}.bvh", io.BytesIO(content + b"\n" * (1 + number + copy)))
            for copy in range(count)
        ]
        options = ImportOptions(project=f"project-{number % 12}", labels=(Label(name, 10, 50),), unit="cm", up="Y")
        done = import_files(database, files, options, Settings())
        if done.problems:
            raise done.problems[0][1]
    database.close()
    unfinished.rename(path)
    return path


def _kinds() -> Iterator[tuple[str, bytes]]:
    rng = np.random.default_rng(1)
    moves = itertools.cycle(("walk", "reach", "wave", "dance"))
    for number, move in zip(range(KINDS), moves, strict=False):
        height, seconds = float(rng.uniform(155, 192)), float(rng.uniform(1, 3))
        size = float(rng.uniform(0.6, 1.4))
        made = {
            "walk": lambda h, s, x: body.walk(h, s, x, 6.0),
            "reach": lambda h, s, x: body.reach(h, s, 40 * x),
            "wave": lambda h, s, x: body.wave(h, s, x),
            "dance": lambda h, s, x: body.dance(h, s, 100 * x, x),
        }[move](height, seconds, size)
        yield move, b"".join(FORMATS["bvh"].write(body.clip(f"{move}_{number}", height, *made), "bvh"))


def fingered(frames: int, seed: int = 1, rate: float = LONG_RATE) -> bytes:
    """A dance as BVH: the demo's body of 21 joints with 4 joints of each finger, together 61."""
    seconds = frames / body.RATE + 1 / body.RATE
    clip = body.clip("dance", 172.0, *body.dance(172.0, seconds, 100.0 + seed, 1.0))
    text = b"".join(FORMATS["bvh"].write(clip, "bvh")).decode()
    hierarchy, _, motion = text.partition("MOTION")
    rng = np.random.default_rng(seed)
    rows = [line for line in motion.split("\n") if line.strip()][2 : 2 + frames]
    values = np.array([line.split() for line in rows], dtype=object)
    place, parts = 6, []
    used = 0
    for joint in clip.head.skeleton.joints[1:]:
        place += 3
        if joint.name.endswith("Hand"):
            parts += [values[:, used:place], _bent(len(values), rng)]
            used = place
    parts.append(values[:, used:])
    lines = [" ".join(row) for row in np.concatenate(parts, axis=1)]
    for side in ("Left", "Right"):
        hierarchy = _with_fingers(hierarchy, side)
    head = f"{hierarchy}MOTION\nFrames: {len(lines)}\nFrame Time: {1 / rate!r}\n"
    return "\n".join([head + lines[0], *lines[1:], ""]).encode()


def _bent(frames: int, rng: np.random.Generator) -> np.ndarray:
    """Angles of 20 joints of fingers that open and close, with four decimals, as text: (frames, 60)."""
    time = np.arange(frames)[:, None] / LONG_RATE
    bend = 20 + 18 * np.sin(2 * np.pi * (0.4 * time + rng.uniform(size=20)))
    values = np.zeros((frames, 20, 3))
    values[..., 0] = bend
    return np.char.mod("%.4f", values.reshape(frames, 60)).astype(object)


def _with_fingers(hierarchy: str, side: str) -> str:
    """The end of a hand is four joints of each of five fingers, each with an end."""
    before, hand, after = hierarchy.partition(f"JOINT {side}Hand")
    head, _, rest = after.partition("End Site")
    tail = rest.partition("}")[2]
    sign = 1 if side == "Left" else -1
    fingers = ""
    for number, finger in enumerate(("Thumb", "Index", "Middle", "Ring", "Pinky")):
        opened = ""
        for part in range(1, 5):
            offset = f"{sign * (7.0 if part == 1 else 2.5):.4f} 0.0000 {(number - 2) * 1.8 if part == 1 else 0:.4f}"
            opened += f"JOINT {side}Hand{finger}{part}\n{{\nOFFSET {offset}\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
        fingers += f"{opened}End Site\n{{\nOFFSET {sign * 2.0:.4f} 0.0000 0.0000\n}}\n" + "}\n" * 4
    return before + hand + head + fingers + tail
