"""The clip in files: its head as elements, its frames as a stream, and data shared with other clips of its skeleton."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from mcml.errors import FormatError, Notice
from mcml.files.check_names import check_head
from mcml.files.clip_files import Clip
from mcml.files.describe_clip import receipt, skeleton_facts
from mcml.files.edit_header import checked_axis, checked_property, checked_unit, with_facts
from mcml.files.import_options import ImportOptions
from mcml.files.limits import FileLimits
from mcml.files.shared_skeleton import SharedSkeleton, shared_skeleton
from mcml.formats import READERS
from mcml.formats.repairs import offers, repaired
from mcml.language.dtd import validate_often
from mcml.language.elements import Element, mcml_element, to_head, write_header
from mcml.language.reader import Limits as McmlLimits
from mcml.language.reader import read_document
from mcml.language.vocabulary import SKELETON
from mcml.motion.clip import ClipHead, ClipStream, Shape

Property = tuple[str, str, str]
"""(name, value, unit)."""


@dataclass
class OpenClip:
    """document: the `mcml` element without motion, to be read only. shared: None where the files are MCML."""

    document: Element
    stream: ClipStream
    shared: SharedSkeleton | None = None
    repaired: bool = False

    def check(self, shapes: Iterable[Shape]) -> None:
        """DocumentError unless what was made of another format's files, with frames of these shapes, is valid.

        A document is valid where each of its elements is: its skeleton was checked when it was made, and uploaded
        MCML while it was read.
        """
        if self.shared is not None:
            bare = mcml_element(self.document.children[0], [Element(SKELETON)])
            others = [(shape, 1) for shape in shapes if shape != self.shared.shape]
            validate_often(bare, others, self.shared.skeleton.names)

    def receipt(self, head: ClipHead, frames: int) -> dict[str, Any]:
        """The receipt, once all frames were read. head: the stored head."""
        facts = skeleton_facts(head.skeleton) if self.shared is None else self.shared.facts
        report = None if self.shared is None else self.shared.report
        return receipt(head, facts, frames, report, self.stream.notices)


def open_made(document: Element, stream: ClipStream, limits: FileLimits) -> OpenClip:
    """A clip that was made here, as if its document had been read. Raises what a document is refused for."""
    check_head(document, stream.head, limits.joints)
    return OpenClip(document, stream.with_head(to_head(document, stream.head.frame_time)))


def open_clip(clip: Clip, options: ImportOptions, limits: FileLimits) -> OpenClip:
    """Open the clip in the files. Raises the errors of readers; a FormatError lists possible repairs."""
    repairs: list[str] = []
    if options.repair:
        files, repairs = repaired(clip.files, options.repair)
        clip = replace(clip, files=files)
    opened = _opened(clip, options, limits)
    opened.stream.notices += [notice for file in clip.files.values() for notice in file.notices]
    opened.stream.notices += [Notice("repair", words) for words in repairs]
    return replace(opened, repaired=bool(repairs))


@contextmanager
def offering(clip: Clip) -> Iterator[None]:
    """A FormatError that is raised within names the repairs that would do something to the files."""
    try:
        yield
    except FormatError as error:
        if "code" not in error.details and (found := offers(clip.files)):
            error.details.update(code="repairable", repairs=found)
        raise


def _opened(clip: Clip, options: ImportOptions, limits: FileLimits) -> OpenClip:
    if clip.format == "mcml":
        read = read_document(clip.files["mcml"].stream, _mcml_limits(limits), options.encoding)
        check_head(read.document, read.clip.head, limits.joints)
        document = with_facts(
            read.document,
            description=options.description or None,
            properties=options.properties or None,
            unit=options.unit,
            up=options.up,
        )
        return OpenClip(document, read.clip.with_head(to_head(document, read.clip.head.frame_time)))
    stream = READERS[clip.format].read(clip.files, options.for_reader(limits, clip.take))
    shared = shared_skeleton(stream, options.aliases)
    fields = {"filename": clip.file_name} | stream.head.fields
    if options.unit:
        fields["calibration_unit"] = checked_unit(options.unit)
    if options.up:
        fields["global_axis_of_gravity"] = checked_axis(options.up)
    head = replace(
        stream.head,
        skeleton=shared.skeleton,
        fields=fields,
        description=options.description.strip(),
        properties=_merge_properties(stream.head.properties, options.properties),
    )
    return OpenClip(mcml_element(write_header(head), shared.elements), stream.with_head(head), shared)


def _merge_properties(of_file: Iterable[Property], stated: Iterable[Property]) -> tuple[Property, ...]:
    """The properties that a reader gives, unless the user states another value of them, and those of the user."""
    checked = [checked_property(*item) for item in stated]
    names = {item[0].casefold() for item in checked}
    return (*(item for item in of_file if item[0].casefold() not in names), *checked)


def _mcml_limits(limits: FileLimits) -> McmlLimits:
    return McmlLimits(max_bytes=limits.size, max_frames=limits.frames)
