"""Marker trials whose joints are known: markers of Plug-in Gait on moving bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, full_shape
from mcml.motion.conventions.resizing import turn_up
from mcml.motion.frames import joined, leave_out
from mcml.motion.kinematics import Walker
from mcml.motion.markers import marker_skeleton
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import Array
from tests.motion.bodies.made import clip_of, person

SIDES = (("L", "left", 1.0), ("R", "right", -1.0))
PELVIS = {"LASI": (12.0, 5.0, 10.0), "RASI": (-12.0, 5.0, 10.0), "LPSI": (5.0, 6.0, -8.0), "RPSI": (-5.0, 6.0, -8.0)}
BOX = {"LFHD": (7.0, 3.0, 9.0), "RFHD": (-7.0, 3.0, 9.0), "LBHD": (7.0, -3.0, -9.0), "RBHD": (-7.0, -3.0, -9.0)}


def markers_on(clip: ClipStream) -> dict[str, Array]:
    """Markers of Plug-in Gait on a body with Y up, (n, 3) each."""
    skeleton = clip.head.skeleton
    places, turns = Walker(skeleton).poses(joined(clip.blocks()))
    at = {name: index for index, name in enumerate(skeleton.names)}

    def fixed(joint: str, offset: Sequence[float], carrier: str = "") -> Array:
        turn = turns[:, at[carrier or joint]]
        return places[:, at[joint]] + rotate(turn, np.broadcast_to(offset, (len(places), 3)))

    found = {name: fixed("Root", offset) for name, offset in PELVIS.items()}
    found |= {name: fixed("Head", offset) for name, offset in BOX.items()}
    found |= {"C7": fixed("neck1", (0.0, 1.0, -6.0), "Root"), "CLAV": fixed("neck1", (0.0, -1.0, 6.0), "Root")}
    for letter, side, out in SIDES:
        for short, joint in (("HJC", "up_leg"), ("KJC", "low_leg"), ("AJC", "foot"), ("SJC", "up_arm"),
                             ("EJC", "low_arm"), ("WJC", "hand")):  # fmt: skip
            found[letter + short] = places[:, at[f"{side}_{joint}"]]
        found[f"{letter}KNE"] = fixed(f"{side}_low_leg", (5.0 * out, 0.0, 0.0), f"{side}_up_leg")
        found[f"{letter}ANK"] = fixed(f"{side}_foot", (4.0 * out, 0.0, 0.0), f"{side}_low_leg")
        found[f"{letter}HEE"] = fixed(f"{side}_foot", (0.0, -3.0, -5.0))
        found[f"{letter}TOE"] = fixed(f"{side}_foot", (1.0 * out, -4.0, 14.0))
    return found


def trial(markers: dict[str, Array], up: str = "Y", **fields: str) -> ClipStream:
    skeleton = marker_skeleton(list(markers))
    values = np.concatenate(list(markers.values()), axis=1)
    columns = skeleton.columns()
    block = FrameBlock(values, columns, (full_shape(columns),), np.arange(1, len(values) + 1))
    stated = {"calibration_unit": "cm", "global_axis_of_gravity": "Y"} | fields
    clip = ClipStream(ClipHead("trc", skeleton, stated, frame_time="0.01"), lambda: iter([block]), len(block))
    return clip if up == "Y" else turn_up(clip, "Y", up)


def with_gaps(clip: ClipStream) -> ClipStream:
    """The same trial, its missing samples as readers state them."""
    block = joined(clip.blocks())
    known = np.isfinite(block.values).reshape(len(block), -1, 3).all(axis=2)
    filled = replace(block, values=np.nan_to_num(block.values))
    holed = leave_out(filled, known)
    return ClipStream(clip.head, lambda: iter([holed]), len(holed))


def pair(frames: int = 12) -> dict[str, Array]:
    """Markers of two people, Anna and Bea: those of `person` 1 and 2."""
    alone = [markers_on(clip_of(person(seed, frames))) for seed in (1, 2)]
    people = zip(("Anna", "Bea"), alone, strict=True)
    return {f"{who}:{name}": place for who, some in people for name, place in some.items()}
