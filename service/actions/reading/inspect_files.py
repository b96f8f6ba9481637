"""A look into files before anything is stored."""

from __future__ import annotations

from typing import Any

from service.actions.reading.gather_files import gathered
from service.actions.reading.import_options import ImportOptions
from service.actions.reading.open_clip import open_clip
from service.errors import McmlError
from service.formats.format import SourceFile
from service.mcml.elements import to_head
from service.motion.clip import Shape
from service.settings import Settings


def inspect_files(
    files: list[SourceFile], options: ImportOptions, settings: Settings
) -> tuple[list[dict[str, Any]], list[tuple[str, McmlError]]]:
    """(what each clip holds, problems): the files are read to the end and checked as an import would."""
    clips: list[dict[str, Any]] = []
    with gathered(files, settings) as found:
        problems = list(found.problems)
        for clip in found.clips:
            try:
                opened = open_clip(clip, options, settings)
                frames = 0
                shapes: dict[Shape, None] = {}
                for block in opened.stream.blocks():
                    frames += len(block)
                    shapes.update(dict.fromkeys(block.shapes))
                head = to_head(opened.document, opened.stream.head.frame_time)
                opened.check(shapes)
                joints = [
                    {"name": joint.name, "source_name": joint.source_name, "parent": joint.parent}
                    for joint in head.skeleton.joints
                ]
                files_of_clip = [file.name for file in clip.files.values()]
                facts = opened.receipt(head, frames)
                clips.append({"files": files_of_clip, "header": head.fields, "joints": joints, "receipt": facts})
            except McmlError as error:
                problems.append((clip.name, error.in_file(clip.name)))
    return clips, problems
