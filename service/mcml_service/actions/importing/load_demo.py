"""The demo library: generated clips in every format, with their motion names and properties."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mcml.files.import_options import ImportOptions, Label
from mcml.files.targets import convert_clip
from mcml.formats import FORMATS
from mcml.formats.format import SourceFile
from mcml.language import joint_names
from mcml.language.elements import from_head
from mcml.language.writer import write_document
from mcml.motion.clip import ClipStream
from mcml_schemas.catalogues import DemoPart, DemoPartLoaded
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.actions.importing.import_pool import ImportPool
from mcml_service.demo import body, face
from mcml_service.demo.dance_clips import Style, dance_clip
from mcml_service.demo.face_takes import face_takes
from mcml_service.demo.reach_clips import reach_clips
from mcml_service.demo.walks import walks
from mcml_service.settings import Settings
from mcml_service.storage.database import Database

REACHES = "demo-reach"
PROJECTS: dict[DemoPart, str] = {
    "people": "demo",
    "reaches": REACHES,
    "dances": "demo-dance",
    "walks": "demo-walk",
    "faces": "demo-face",
}
"""Parts of the demo library, and the project of each."""

TEMPI: dict[Style, tuple[float, ...]] = {
    "groove": (100.0, 118.0, 132.0),
    "step": (96.0, 112.0, 128.0),
    "accent": (120.0,),
    "wave": (108.0,),
}
"""Styles of the generated dances, and the beats a minute of their clips."""


@dataclass(frozen=True)
class Storing:
    """Where demo clips are stored, and by whom. pool: as of `import_files`."""

    database: Database
    settings: Settings
    author: str = "demo"
    pool: ImportPool | None = None

    def store(self, files: list[SourceFile], options: ImportOptions) -> Counter[bool]:
        """Import files; existing clips are skipped. Returns numbers of clips, by whether they existed.

        Raises the first error of a file.
        """
        options = replace(options, on_duplicate="skip")
        done = import_files(self.database, files, options, self.settings, author=self.author, pool=self.pool)
        for _, error in done.problems:
            raise error
        return Counter(document.skipped for document in done.documents)


def load_demo(
    database: Database,
    settings: Settings,
    parts: Iterable[DemoPart] = tuple(PROJECTS),
    *,
    project: str | None = None,
    seed: int = 1,
    author: str = "demo",
    pool: ImportPool | None = None,
) -> list[DemoPartLoaded]:
    """Store parts of the demo library; clips that the project has already are skipped. Raises what an import raises.

    people: three people: walks, reaches, waves, dances and faces, in every format. For analyses there are 185
    reaches, eight dances and ten takes of a face; for motion matching there are walks that turn.
    project: for all clips; None: that of each part (`PROJECTS`). seed: another one makes other clips.
    """
    storing = Storing(database, settings, author, pool)
    loaded = []
    for part in parts:
        target = PROJECTS[part] if project is None else project
        if part == "people":
            counts = _load_people(storing, target, seed)
        else:
            counts = add_clips(database, settings, target, *_clips_of(part, seed), author=author, pool=pool)
        loaded.append(DemoPartLoaded(part=part, project=target, stored=counts[False], existing=counts[True]))
    return loaded


def _clips_of(part: DemoPart, seed: int) -> tuple[Sequence[ClipStream], tuple[Label, ...], str]:
    """Return the clips of a part with one kind of clips, their labels, and their description."""
    if part == "reaches":
        return [item.clip for item in reach_clips(seed)], (Label("reach"),), "A generated reach for the seat belt."
    if part == "dances":
        clips = [
            dance_clip(style, tempo=tempo, bars=16, seed=seed * 10 + number, name=f"{style}_{tempo:.0f}").clip
            for style, tempi in TEMPI.items()
            for number, tempo in enumerate(tempi)
        ]
        return clips, (Label("dance"),), "A generated dance."
    if part == "walks":
        return walks(), (Label("walk"),), "A generated walk."
    clips = [take.clip for take in face_takes(seed, head=True, noise=0.05)]
    return clips, (), "A generated take of a face, 100 markers."


def demo_files(seed: int = 1) -> dict[str, bytes]:
    """Files to try commands with: a walk as walk.bvh, a reach as reach.asf and reach.amc."""
    rng = np.random.default_rng(seed)
    walk = body.clip("walk", 172.0, *body.walk(172.0, 4.0, rng.uniform(0.85, 1.1), rng.uniform(4, 9)))
    reach = body.clip("reach", 172.0, *body.reach(172.0, rng.uniform(1.8, 2.6), 30.0))
    made = [*_files("walk", "bvh", walk), *_files("reach", "asf-amc", reach)]
    return {file.name: file.stream.read() for file in made}


def _load_people(storing: Storing, project: str, seed: int) -> Counter[bool]:
    """Store three people: walks, reaches, waves, dances and faces, in every format."""
    rng = np.random.default_rng(seed)
    count: Counter[bool] = Counter()
    for person in range(3):
        age, height = int(rng.integers(18, 70)), float(round(rng.uniform(155, 192), 1))
        about = (("age", str(age), "year"), ("height", str(height), "cm"), ("actor", f"actor {person + 1}", ""))
        name = f"walk_{person + 1}"
        clip = body.clip(name, height, *body.walk(height, 4.0, rng.uniform(0.85, 1.1), rng.uniform(4, 9)))
        count += _add(storing, project, name, "bvh", clip, (Label("walk"),), about)
        name = f"reach_{person + 1}"
        elevation = float(round(rng.uniform(-20, 70), 1))
        clip = body.clip(name, height, *body.reach(height, rng.uniform(1.8, 2.6), elevation))
        properties = (*about, ("elevation", str(elevation), "degree"))
        count += _add(storing, project, name, "asf-amc", clip, (Label("reach"),), properties)
        name = f"wave_{person + 1}"
        clip = body.clip(name, height, *body.wave(height, 3.5, rng.uniform(1.2, 2.0)))
        last = clip.frames or 0
        raised = (
            Label("wave", 1, last),
            Label("left-arm-abduction", 1, 48),
            Label("left-arm-adduction", last - 47, last),
        )
        count += _add(storing, project, name, "htr", clip, raised, about)
        name = f"dance_{person + 1}"
        tempo = float(rng.integers(96, 132))
        clip = body.clip(name, height, *body.dance(height, 8.0, tempo, rng.uniform(0.6, 1.4)))
        properties = (*about, ("tempo", str(tempo), "bpm"))
        count += _add(
            storing, project, name, "mcml", clip, (Label("dance"), *_bars(tempo, clip.frames or 0)), properties
        )
        text, labels = face.face_htr(seed * 100 + person)
        count += storing.store(
            [SourceFile(f"face_{person + 1}.htr", io.BytesIO(text))],
            ImportOptions(project=project, labels=tuple(Label(*label) for label in labels), properties=about),
        )
    return count


def _bars(tempo: float, frames: int) -> tuple[Label, ...]:
    length = 4 * 60 / tempo * body.RATE
    return tuple(
        Label(f"bar-{number + 1}", round(number * length) + 1, round((number + 1) * length))
        for number in range(int(frames / length))
    )


def _add(
    storing: Storing,
    project: str,
    name: str,
    target: str,
    clip: ClipStream,
    labels: tuple[Label, ...],
    properties: tuple[tuple[str, str, str], ...],
) -> Counter[bool]:
    unit = "cm" if target != "htr" else None
    files = _files(name, target, clip)
    options = ImportOptions(
        project=project,
        name=name,
        labels=labels,
        properties=properties,
        unit=unit,
        up="Y" if target != "htr" else None,
        frame_time=clip.head.frame_time if target == "asf-amc" else None,
        description="Generated for the demo library.",
    )
    return storing.store(files, options)


def add_clips(
    database: Database,
    settings: Settings,
    project: str,
    clips: Sequence[ClipStream],
    labels: tuple[Label, ...],
    description: str,
    *,
    author: str = "demo",
    pool: ImportPool | None = None,
) -> Counter[bool]:
    """Store clips, with the properties they have, in one call. Returns numbers of clips, by whether they existed."""
    files = []
    for clip in clips:
        fields = {"calibration_unit": "cm", "global_axis_of_gravity": "Y"} | clip.head.fields
        described = clip.with_head(replace(clip.head, fields=fields, description=description))
        files += _files(clip.head.fields["filename"].rpartition(".")[0], "mcml", described)
    return Storing(database, settings, author, pool).store(files, ImportOptions(project=project, labels=labels))


def _files(name: str, target: str, clip: ClipStream) -> list[SourceFile]:
    if target == "mcml":
        head = replace(clip.head, skeleton=joint_names.named(clip.head.skeleton)[0])
        content = write_document(from_head(head), clip.frames or 0, head.frame_time, clip.blocks(), head.skeleton.names)
        return [SourceFile(f"{name}.mcml", io.BytesIO(b"".join(content)))]
    converted = convert_clip(clip, target)
    return [
        SourceFile(f"{name}{part.extensions[0]}", io.BytesIO(b"".join(FORMATS[target].write(converted, part.name))))
        for part in FORMATS[target].parts
    ]
