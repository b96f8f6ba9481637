"""Draw the animations of docs/made-motion.md from the demo library: `python -m tests.docs.animations [NAME ...]`."""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

import mcml
from mcml.client.repository import Document, Repository
from mcml.motion.skeleton import Array
from mcml_service.actions.importing.load_demo import load_demo
from mcml_service.settings import Settings
from mcml_service.storage.database import Database

FOLDER = Path(__file__).resolve().parents[2] / "docs/pictures/made"
RATE, LONGEST = 15.0, 8.0
"""Pictures a second, and seconds, of an animation."""
WIDTH, HEIGHT, MARGIN = 320, 240, 18
TURN, DOWN = np.radians(40.0), np.radians(18.0)
PAPER, WAY = "#ffffff", "#b9c2cc"
BEFORE, AFTER = "#6b7280", "#0f62fe"
METRE = 100.0
"""Units of the demo library, centimetres."""


@dataclass(frozen=True)
class Shown:
    """A motion: positions (n, J, 3) at so many frames a second, bones as pairs of joints, and points to mark (m, 3)."""

    positions: Array
    rate: float
    bones: list[tuple[int, int]]
    marks: Array


def show(document: Document, marks: list[list[float]] | None = None) -> Shown:
    """A stored motion. marks: points in metres."""
    names = document.skeleton().bones
    bones = [(bone.parent, index) for index, bone in enumerate(names) if bone.parent >= 0]
    assert document.frame_time is not None
    points = np.array(marks or np.zeros((0, 3)), dtype=float) * METRE
    return Shown(np.asarray(document.frames(space="positions")), 1 / document.frame_time, bones, points)


class Maker:
    """The demo library, and motions made of it."""

    def __init__(self, repo: Repository) -> None:
        self.repo = repo
        self.call: Any = repo.operations

    def id(self, name: str) -> str:
        return self.repo.document(name).id

    def compose(self, *pieces: tuple[str, int, int], **options: Any) -> Document:
        segments = [{"document": uuid, "first": first, "last": last} for uuid, first, last in pieces]
        made = self.call.compose(request={"segments": segments, "project": "made", **options})
        return self.repo.document(made.document)

    def copy(self, name: str, first: int = 1, last: int = 200) -> Document:
        return self.compose((self.id(name), first, last))

    def edit(self, document: Document, *edits: dict[str, Any]) -> Document:
        """A copy with edits."""
        copy = self.compose((document.id, 1, len(document)))
        self.call.edit_frames(id=copy.id, edits={"edits": list(edits)}, if_match="*")
        return copy.refresh()

    def disturb(self, name: str, change: Callable[[Array], None]) -> Document:
        """A copy with other numbers in the channels of its joints below the root."""
        document = self.copy(name)
        values = document.frames()
        numbers = np.array(values)
        change(numbers)
        content = json.dumps({"columns": list(values.columns), "values": numbers.tolist()}).encode()
        self.call.put_frames(id=document.id, content=content, if_match="*")
        return document.refresh()

    def result(self, analysis: str, project: str, **parameters: Any) -> str:
        """The result of a finished analysis."""
        start = getattr(self.call, f"start_{analysis}")
        job = start(request={"inputs": {"project": project}, "parameters": parameters})
        done = self.repo.finish(job)
        assert done.result is not None, done
        return done.result


def transition(maker: Maker) -> tuple[Shown, Shown]:
    pieces = [(maker.id("walk_straight"), 1, 130), (maker.id("wave_1"), 1, 140)]
    return show(maker.compose(*pieces, transition=0)), show(maker.compose(*pieces))


def phase(maker: Maker) -> tuple[Shown, Shown]:
    pieces = [(maker.id("walk_straight"), 1, 150), (maker.id("walk_left_50"), 30, 300)]
    before, after = (maker.compose(*pieces, style="crossfade", match_phase=match) for match in (False, True))
    return show(before), show(after)


def loop(maker: Maker) -> tuple[Shown, Shown]:
    raw = maker.copy("walk_straight", 20, 130)
    once = maker.edit(raw, {"do": "loop", "first": 1, "last": len(raw)})
    rounds = [maker.compose(*[(one.id, 1, len(one))] * 4, transition=0) for one in (raw, once)]
    return show(rounds[0]), show(rounds[1])


def feet(maker: Maker) -> tuple[Shown, Shown]:
    before = maker.copy("walk_straight")
    return show(before), show(maker.edit(before, {"do": "lock-feet", "first": 1, "last": len(before)}))


def spikes(maker: Maker) -> tuple[Shown, Shown]:
    def change(values: Array) -> None:
        chance = np.random.default_rng(2)
        for column in range(6, values.shape[1], 4):
            values[chance.choice(len(values), 4, replace=False), column] += chance.choice([-60.0, 60.0], 4)

    before = maker.disturb("wave_1", change)
    return show(before), show(maker.edit(before, {"do": "despike", "first": 1, "last": len(before)}))


def noise(maker: Maker) -> tuple[Shown, Shown]:
    def change(values: Array) -> None:
        values[:, 6:] += np.random.default_rng(3).normal(0, 2.5, values[:, 6:].shape)

    before = maker.disturb("walk_1", change)
    return show(before), show(maker.edit(before, {"do": "low-pass", "hertz": 6, "first": 1, "last": len(before)}))


def retargeting(maker: Maker) -> tuple[Shown, Shown]:
    source = maker.copy("dance_1", 1, 300)
    made = maker.call.retarget(id=source.id, request={"skeleton": maker.id("walk_3"), "clean_feet": True})
    return show(source), show(maker.repo.document(made.document))


def reach(maker: Maker) -> tuple[Shown, Shown]:
    model = maker.result("reach", "demo-reach")
    attributes = {"age": 40, "height": 172, "hbp": 65}
    free = maker.call.use_synthesize(id=model, request={"parameters": {"attributes": attributes}})
    place = list(free.value.hand_place)
    target = [place[0] - 0.08, place[1] + 0.1, place[2]]
    shown = []
    for wish in ({}, {"target": target}):
        parameters = {"attributes": attributes, **wish}
        used = maker.call.use_synthesize(
            id=model, request={"parameters": parameters, "save": True, "project": "made", "name": f"reach {len(shown)}"}
        )
        shown.append(show(maker.repo.document(used.document), [target]))
    return shown[0], shown[1]


def dance(maker: Maker) -> tuple[Shown, Shown]:
    shown = []
    for name, wish in (("alone", {}), ("group", {"dancers": {"count": 3, "mode": "canon", "delay": 2}})):
        result = maker.result("dance", "demo-dance", bars=24, bpm=116, name=f"dance {name}", **wish)
        clip = maker.call.get_result_part(id=result, part="clip")
        shown.append(show(maker.repo.document(clip.document)))
    return shown[0], shown[1]


def path(maker: Maker) -> tuple[Shown, Shown]:
    way = np.linspace(0, 2 * np.pi, 80)
    points = np.stack([2.2 * np.sin(way), 1.1 * np.sin(2 * way)], axis=1)
    wish = {"selection": {"project": "demo-walk"}, "path": points.tolist(), "project": "made"}
    made = maker.call.follow_path(request=wish)
    marks = [[x, 0.0, z] for x, z in points.tolist()]
    return show(maker.repo.document("walk_left_50")), show(maker.repo.document(made.document), marks)


RESULTS = (transition, phase, loop, feet, spikes, noise, retargeting, reach, dance, path)


def main() -> None:
    """Write an animation of each result, or of those that are named."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        store = Path(name) / "demo.db"
        database = Database(f"sqlite:///{store}")
        database.migrate()
        load_demo(database, Settings())
        database.close()
        with mcml.open(str(store)) as repo:
            for make in RESULTS:
                if not sys.argv[1:] or make.__name__ in sys.argv[1:]:
                    draw(*make(Maker(repo)), FOLDER / f"{make.__name__}.webp")


def draw(before: Shown, after: Shown, file: Path) -> None:
    """Draw two motions side by side, at one scale, each with the way of its root on the ground."""
    sides = [(before, BEFORE), (after, AFTER)]
    seconds = min(LONGEST, max(len(one.positions) / one.rate for one, _ in sides))
    views = [project(one.positions[: round(seconds * one.rate)]) for one, _ in sides]
    spans = [np.ptp(view.reshape(-1, 2), axis=0) for view in views]
    scale = min((WIDTH - 2 * MARGIN) / max(s[0] for s in spans), (HEIGHT - 2 * MARGIN) / max(s[1] for s in spans))
    pictures = []
    for index in range(round(seconds * RATE)):
        picture = Image.new("RGB", (2 * WIDTH, HEIGHT), PAPER)
        pen = ImageDraw.Draw(picture)
        for place, ((one, colour), view) in enumerate(zip(sides, views, strict=True)):
            frame = min(round(index / RATE * one.rate), len(view) - 1)
            middle = (view.reshape(-1, 2).min(axis=0) + view.reshape(-1, 2).max(axis=0)) / 2
            draw_side(pen, one, view, frame, colour, lambda at, m=middle, p=place: to_paper(at, m, scale, p))
        pictures.append(picture)
    pictures[0].save(
        file, save_all=True, append_images=pictures[1:], duration=round(1000 / RATE), loop=0, quality=55, method=4
    )


def project(points: Array) -> Array:
    """Points (..., 3), Y up, seen from the side and a little above: (..., 2) right and down."""
    x, y, z = np.moveaxis(points, -1, 0)
    right, depth = np.cos(TURN) * z - np.sin(TURN) * x, np.sin(TURN) * z + np.cos(TURN) * x
    return np.stack([right, -np.cos(DOWN) * y + np.sin(DOWN) * depth], axis=-1)


def to_paper(at: Array, middle: Array, scale: float, place: int) -> tuple[float, float]:
    x, y = (at - middle) * scale + [WIDTH * (place + 0.5), HEIGHT / 2]
    return float(x), float(y)


def draw_side(pen: Any, one: Shown, view: Array, frame: int, colour: str, paper: Callable[[Array], Any]) -> None:
    floor = one.positions[: len(view), 0].copy()
    floor[:, 1] = one.positions[..., 1].min()
    pen.line([paper(at) for at in project(floor)], fill=WAY, width=2)
    for at in project(one.marks):
        x, y = paper(at)
        pen.ellipse([x - 2, y - 2, x + 2, y + 2], outline="#d92d20")
    for start, end in one.bones:
        pen.line([paper(view[frame, start]), paper(view[frame, end])], fill=colour, width=3)


if __name__ == "__main__":
    main()
