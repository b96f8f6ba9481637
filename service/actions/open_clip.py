"""The clip in files: its head as elements, its frames as a stream, and how its joints were named."""

from __future__ import annotations

from dataclasses import replace

from service.actions.check_names import check_head
from service.actions.edit_header import checked_axis, checked_property, checked_unit, with_facts
from service.actions.gather_files import Clip
from service.actions.import_options import ImportOptions
from service.formats import FORMATS
from service.formats.format import Limits, ReadOptions
from service.mcml import joint_names
from service.mcml.elements import Element, from_head, to_head
from service.mcml.joint_names import NamingReport
from service.mcml.reader import Limits as McmlLimits
from service.mcml.reader import read_document
from service.motion.clip import ClipStream
from service.settings import Settings


def open_clip(
    clip: Clip, options: ImportOptions, settings: Settings
) -> tuple[Element, ClipStream, NamingReport | None]:
    """The `mcml` element without motion, the stream of frames, and how joints were named, of a clip's files."""
    if clip.format == "mcml":
        read = read_document(clip.files["mcml"].stream, _mcml_limits(settings), options.encoding)
        check_head(read.document, read.clip.head, settings.max_joints)
        document = with_facts(
            read.document,
            description=options.description or None,
            properties=options.properties or None,
            unit=options.unit,
            up=options.up,
        )
        return document, read.clip.with_head(to_head(document, read.clip.head.frame_time)), None
    reader = ReadOptions(encoding=options.encoding, translation=options.translation, limits=_limits(settings))
    stream = FORMATS[clip.format].read(clip.files, reader)
    skeleton, report = joint_names.named(stream.head.skeleton)
    fields = {"filename": clip.name.rsplit("/", 1)[-1]} | stream.head.fields
    if options.unit:
        fields["calibration_unit"] = checked_unit(options.unit)
    if options.up:
        fields["global_axis_of_gravity"] = checked_axis(options.up)
    head = replace(
        stream.head,
        skeleton=skeleton,
        fields=fields,
        description=options.description.strip(),
        properties=tuple(checked_property(*item) for item in options.properties),
    )
    return from_head(head), stream.with_head(head), report


def _limits(settings: Settings) -> Limits:
    return Limits(
        joints=settings.max_joints,
        frames=settings.max_frames,
        values=settings.max_values,
        seconds=settings.read_seconds,
        memory=settings.read_memory_mib << 20,
    )


def _mcml_limits(settings: Settings) -> McmlLimits:
    return McmlLimits(max_bytes=settings.max_upload_bytes, max_frames=settings.max_frames)
