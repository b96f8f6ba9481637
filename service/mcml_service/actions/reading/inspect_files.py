"""A look into files before anything is stored."""

from __future__ import annotations

from typing import Any

from mcml.errors import McmlError
from mcml.files.gather_files import gathered
from mcml.files.import_options import ImportOptions
from mcml.files.open_clip import offering, open_clip
from mcml.formats.format import SourceFile
from mcml.language.elements import to_head
from mcml.motion.clip import FrameBlock, Shape
from mcml_service.actions.reading.preview_motion import Window, preview_motion
from mcml_service.settings import Settings


def inspect_files(
    files: list[SourceFile], options: ImportOptions, settings: Settings, window: Window | None = None
) -> tuple[list[dict[str, Any]], list[tuple[str, McmlError]]]:
    """Return (the content of each clip, problems): the files are read to the end and checked as in an import.

    window: frames whose positions are returned.
    """
    clips: list[dict[str, Any]] = []
    with gathered(files, settings.file_limits, options=options) as gathering:
        problems = list(gathering.problems)
        for clip in gathering.clips:
            try:
                with offering(clip):
                    opened = open_clip(clip, options, settings.file_limits)
                    frames = 0
                    shapes: dict[Shape, None] = {}
                    kept: list[FrameBlock] = []
                    for block in opened.stream.blocks():
                        if window is not None and frames < window.end:
                            kept.append(block)
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
                    found_clip = {"files": files_of_clip, "header": head.fields, "joints": joints, "receipt": facts}
                    if window is not None:
                        motion = preview_motion(head, kept, window, head.seconds_per_frame())
                        found_clip["motion"] = motion.model_dump()
                    clips.append(found_clip)
            except McmlError as error:
                problems.append((clip.name, error.in_file(clip.name)))
    return clips, problems
