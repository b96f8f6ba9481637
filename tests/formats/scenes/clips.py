"""Clips that leave as scenes, by what they show."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from mcml.formats import FORMATS
from mcml.motion.clip import ClipHead, ClipStream
from mcml.motion.skeleton import Convention, Skeleton
from mcml.testing import read
from tests.builders import ASF, HTR, TRC, amc, bvh, c3d_file
from tests.formats.scenes.reading import stating
from tests.motion.bodies.made import clip_of, person
from tests.motion.random_clips import random_clip

HOSTILE = (
    *("", "a/b", "../..", "a.b:c|d", '"\\"', "<b>", "{%s}", "constructor", "__proto__", "Root", "Root"),
    *("머리", "é́\u202e", "1st", "C:\\nul", "a\tb", "a\u0000b", "x" * 300, "def Xform", "endheader", "\ud800"),
)


def hostile() -> ClipStream:
    """A body whose joints have names that somebody may stumble over."""
    clip = clip_of(person(3, 5))
    joints = [replace(joint, source_name=name) for joint, name in zip(clip.head.skeleton.joints, HOSTILE, strict=False)]
    joints += clip.head.skeleton.joints[len(joints) :]
    fields = {"filename": 'endheader\nnRows=9\t"\u2028</x>.bvh'}
    return clip.with_head(replace(clip.head, skeleton=Skeleton(tuple(joints)), fields=fields))


def timed(clip: ClipStream) -> ClipStream:
    """The clip of a format without frame times, with one."""
    return clip.with_head(replace(clip.head, frame_time=clip.head.frame_time or "0.0083333"))


def cut(clip: ClipStream, frames: int) -> ClipStream:
    """Its first frames, of which there are none or one."""

    def blocks():  # type: ignore[no-untyped-def]
        for block in clip.blocks():
            if frames:
                yield replace(block, values=block.values[:1], ids=block.ids[:1], shape_of=None, motion_names=None)
                return

    return ClipStream(clip.head, blocks, frames, [])


def _big() -> ClipStream:
    """Frames in several blocks that begin far away."""
    clip = clip_of(person(5, 1500))

    def blocks():  # type: ignore[no-untyped-def]
        for block in clip.blocks():
            for first in range(0, len(block), 400):
                rows = slice(first, first + 400)
                yield replace(block, values=block.values[rows], ids=block.ids[rows])

    return ClipStream(clip.head, blocks, None, [])


CLIPS: dict[str, Callable[[], ClipStream]] = {
    "bvh": lambda: clip_of(person(1)),
    "asf": lambda: clip_of(person(1), Convention.FIXED),
    "htr": lambda: clip_of(person(1), Convention.BASE),
    "many frames": _big,
    "htr with gaps": lambda: read(FORMATS["htr"], {"htr": HTR}),
    "a leg": lambda: timed(read(FORMATS["asf-amc"], {"asf": ASF, "amc": amc(5)})),
    "chain": lambda: read(FORMATS["bvh"], {"bvh": bvh(9)}),
    "trc": lambda: read(FORMATS["trc"], {"trc": TRC}),
    "c3d": lambda: read(FORMATS["c3d"], {"c3d": c3d_file(40, 12)}),
    "hostile names": hostile,
    "one frame": lambda: cut(clip_of(person(4)), 1),
    **{
        f"{convention.value} {seed}": lambda convention=convention, seed=seed: random_clip(  # type: ignore[misc]
            convention, seed, moving=seed % 2 == 1, radians=seed % 3 == 2
        )
        for convention in (Convention.LISTED, Convention.FIXED, Convention.BASE)
        for seed in range(6)
    },
}

STATED = {
    "centimetres, Z up": ({"calibration_unit": "cm", "global_axis_of_gravity": "Z"}, 0.01, "Z"),
    "millimetres, Y up": ({"calibration_unit": "MM", "global_axis_of_gravity": "Y"}, 0.001, "Y"),
    "inches, X up": ({"calibration_unit": "inch", "global_axis_of_gravity": "x"}, 0.0254, "X"),
    "metres, Y down": ({"calibration_unit": "m", "global_axis_of_gravity": "-Y"}, 1.0, "-Y"),
    "a unit of its own": ({"calibration_unit": "furlong"}, 1.0, "Y"),
}
"""Fields of the header; metres of its unit, and the axis that is up."""


def without_joints() -> ClipStream:
    head = ClipHead("bvh", Skeleton(()), frame_time="0.01")
    return ClipStream(head, lambda: iter(()), 0)


def stated(title: str, clip: ClipStream | None = None) -> tuple[ClipStream, float, str]:
    fields, metres, up = STATED[title]
    return stating(clip or clip_of(person(2, 12)), **fields), metres, up


def enormous() -> ClipStream:
    """Joints further away than single precision can say."""
    clip = clip_of(person(1, 3))
    skeleton = clip.head.skeleton
    far = replace(skeleton.joints[2], offset=("1e39", "0", "0"))
    return clip.with_head(replace(clip.head, skeleton=Skeleton((*skeleton.joints[:2], far, *skeleton.joints[3:]))))


def told(clip: ClipStream) -> tuple[float, str]:
    """Metres of the unit that the header states, and its axis that is up."""
    fields = clip.head.fields
    metres = {"mm": 0.001, "cm": 0.01, "inch": 0.0254}.get(fields.get("calibration_unit", "").lower(), 1.0)
    return metres, fields.get("global_axis_of_gravity", "Y").upper()
