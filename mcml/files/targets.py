"""Targets of exports: formats, parts of formats, and the conversion of a clip for each."""

from __future__ import annotations

from dataclasses import replace

from mcml.errors import UnsupportedError
from mcml.formats import SHAPED, SKINNED, WRITERS
from mcml.language import joint_names
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.blend_shapes import without_blend_shapes
from mcml.motion.conventions.convert import convert
from mcml.motion.solving.marker_skeleton import with_skeleton


def targets() -> dict[str, tuple[str, str | None]]:
    """Formats that files are written in: name -> (catalogue name, part or None for all parts)."""
    result: dict[str, tuple[str, str | None]] = {"mcml": ("mcml", None), "csv": ("csv", None)}
    for name, format_ in WRITERS.items():
        result[name] = (name, format_.parts[0].name if len(format_.parts) == 1 else None)
        if len(format_.parts) > 1:
            result.update({part.name: (name, part.name) for part in format_.parts})
    return result


def find_target(name: str) -> tuple[str, str | None]:
    """Return the entry of `targets` for a requested format. Raises UnsupportedError, with the available formats."""
    known = targets()
    if name not in known:
        raise UnsupportedError(f"Unknown export format {name!r}.", remedy=f"Use one of: {', '.join(sorted(known))}.")
    return known[name]


def check_character(name: str) -> None:
    """Raises UnsupportedError for a format that holds no body with a skin."""
    if name not in SKINNED:
        raise UnsupportedError(
            f"{WRITERS[name].label if name in WRITERS else name.upper()} holds no body with a skin.",
            remedy=f"Leave out `character`, or use one of: {', '.join(sorted(SKINNED))}.",
        )


def part_without_frames(name: str) -> str | None:
    """Return the part of a format for a skeleton alone, because a motion file without frames is invalid.

    None for formats with one part.
    """
    parts = WRITERS[name].parts if name in WRITERS else ()
    return parts[0].name if len(parts) > 1 else None


def convert_clip(clip: ClipStream, name: str, names: str | None = None) -> ClipStream:
    """The clip as a format of the catalogue can write it; `names`: with joint names of that table.

    Markers get a skeleton for formats that hold only joints, and for a body with a skin. Raises ConversionError where
    they show none.
    """
    writer = WRITERS[name]
    convention = writer.convention
    if not writer.markers or clip.character:
        clip = with_skeleton(clip)
    if convention is not None:
        clip = convert(clip, convention)
    elif name not in SHAPED:
        clip = without_blend_shapes(clip)
    if names:
        skeleton = joint_names.translate(clip.head.skeleton, names)
        clip = clip.with_head(replace(clip.head, skeleton=skeleton))
    return clip
