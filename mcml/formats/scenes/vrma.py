"""VRM Animation 1.0: a GLB whose nodes are the humanoid bones of VRM, at rest in its T-pose.

Sources: VRM Consortium, VRMC_vrm_animation 1.0 (humanoid bones, rest pose, no translations but the hips'; about 30
frames a second are suggested) and VRMC_vrm 1.0 (humanoid, T-pose).
"""

from __future__ import annotations

from collections.abc import Iterator

from mcml.errors import ConversionError
from mcml.formats.format import FileKind, need_seconds
from mcml.formats.scenes.glb import need_library, write_stage
from mcml.formats.scenes.stage import look_through
from mcml.formats.transfer import match_person, transfer
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import with_scale_factor
from mcml.motion.lexemes import lexeme
from mcml.motion.retargeting.bone_mapping import Match
from mcml.motion.skeleton import ROTATIONS, TRANSLATIONS, Convention, Joint, Skeleton

_TRUNK = (
    ("hips", "", (0.0, 0.95, 0.0)),
    ("spine", "hips", (0.0, 0.11, 0.0)),
    ("chest", "spine", (0.0, 0.135, 0.0)),
    ("upperChest", "chest", (0.0, 0.06, 0.0)),
    ("neck", "upperChest", (0.0, 0.215, 0.0)),
    ("head", "neck", (0.0, 0.08, 0.0)),
    ("jaw", "head", (0.0, -0.02, 0.03)),
)
"""Bones, their parents and their offsets at rest in metres: a general adult of 1.70 m, facing +Z, left at +X."""
_SIDE = (
    ("UpperLeg", "hips", (0.07, -0.09, 0.0)),
    ("LowerLeg", "UpperLeg", (0.0, -0.38, 0.0)),
    ("Foot", "LowerLeg", (0.0, -0.40, 0.0)),
    ("Toes", "Foot", (0.0, -0.055, 0.12)),
    ("Shoulder", "upperChest", (0.08, 0.12, 0.0)),
    ("UpperArm", "Shoulder", (0.095, 0.0, 0.0)),
    ("LowerArm", "UpperArm", (0.255, 0.0, 0.0)),
    ("Hand", "LowerArm", (0.25, 0.0, 0.0)),
    ("ThumbMetacarpal", "Hand", (0.03, 0.0, 0.03)),
    ("ThumbProximal", "ThumbMetacarpal", (0.021, 0.0, 0.021)),
    ("ThumbDistal", "ThumbProximal", (0.021, 0.0, 0.021)),
)
"""Bones of the left side; those of the right side are mirrored."""
_FINGERS = {"Index": 0.02, "Middle": 0.0, "Ring": -0.02, "Little": -0.04}
_SIDES = ("left", "right")
_REQUIRED = (
    "hips", "head",
    *(side + bone for side in ("left", "right") for bone in (
        "UpperLeg", "LowerLeg", "Foot", "UpperArm", "LowerArm", "Hand")),
)  # fmt: skip
"""Bones that VRM requires of every humanoid, besides the spine."""
_CHAINS = (
    ("spine", "chest", "upperChest"),
    *(tuple(f"{side}Thumb{part}" for part in ("Metacarpal", "Proximal", "Distal")) for side in _SIDES),
    *(
        tuple(f"{side}{finger}{part}" for part in ("Proximal", "Intermediate", "Distal"))
        for side in _SIDES
        for finger in _FINGERS
    ),
)
"""Bones that exist only with those before them."""


class Vrma:
    """The format `vrma`; see `mcml.formats.format.Writer`."""

    name = "vrma"
    title = "VRM Animation 1.0"
    label = "VRM Animation"
    parts = (FileKind("vrma", (".vrma",), "Motion of humanoid bones"),)
    convention = None
    media_type = "model/gltf-binary"
    bodies, markers = True, False
    needs = frozenset({"frame_time"})
    assumes = "m"

    def write(self, clip: ClipStream, part: str) -> Iterator[bytes]:
        need_library()
        clip = with_scale_factor(clip)
        seconds = need_seconds(clip.head, self.title)
        whole = make_humanoid()
        matches = match_person(clip, whole, _REQUIRED, self.title)
        used = _fill_chains({whole.joints[match.target].name: match for match in matches})
        if "spine" not in used:
            raise ConversionError(
                f"{self.title} needs a spine, and the clip has no joint between hips and neck",
                remedy="Give one the name `waist` with aliases, or export as glTF.",
            )
        target = make_humanoid(frozenset(used))
        # Bones that the clip lacks are left out: each avatar moves them as it does.
        renumbered = [
            Match(used[joint.name].source, index, used[joint.name].confidence, used[joint.name].reason)
            for index, joint in enumerate(target.joints)
        ]
        made = transfer(clip, target, renumbered, seconds, "a general body in VRM's T-pose")
        if not made.frames:
            raise ConversionError(
                "the clip has no frames, and VRM Animation holds a motion", remedy="Export it as glTF."
            )
        bones = {joint.name: {"node": index} for index, joint in enumerate(target.joints)}
        facts = {"specVersion": "1.0", "humanoid": {"humanBones": bones}}
        return write_stage(look_through(made, self.title, "metres"), {"VRMC_vrm_animation": facts})


def _fill_chains(used: dict[str, Match]) -> dict[str, Match]:
    """Rename matched bones so that no chain has a gap: a single joint of the trunk is the spine."""
    for chain in _CHAINS:
        there = [used.pop(name) for name in chain if name in used]
        used |= dict(zip(chain, there, strict=False))
    return used


def make_humanoid(used: frozenset[str] | None = None) -> Skeleton:
    """Return the humanoid of VRM in its T-pose, each bone before its children.

    used: the bones to have, by default all; bones below others that are left out hang from the nearest one above, at
    the same place.
    """
    joints: list[Joint] = []
    index: dict[str, int] = {}
    skipped: dict[str, tuple[str, tuple[float, float, float]]] = {}
    for name, parent, offset in _list_bones():
        while parent in skipped:
            parent, more = skipped[parent]
            offset = (offset[0] + more[0], offset[1] + more[1], offset[2] + more[2])
        if used is not None and name not in used:
            skipped[name] = parent, offset
            continue
        index[name] = len(joints)
        joints.append(
            Joint(
                name=name,
                parent=index[parent] if parent else -1,
                source_name=name,
                convention=Convention.LISTED,
                channels=(() if parent else TRANSLATIONS) + tuple(reversed(ROTATIONS)),
                rotation_order="ZYX",
                offset=(lexeme(offset[0]), lexeme(offset[1]), lexeme(offset[2])),
                translation="" if parent else "absolute",
            )
        )
    return Skeleton(tuple(joints))


def _list_bones() -> list[tuple[str, str, tuple[float, float, float]]]:
    """All bones, each with its parent above it in the list and with its subtree in one piece."""
    rows = [*_TRUNK]
    fingers = [
        (f"{finger}{part}", f"{finger}{above}" if above else "Hand", (0.03, 0.0, 0.0) if above else (0.095, 0.0, depth))
        for finger, depth in _FINGERS.items()
        for above, part in (("", "Proximal"), ("Proximal", "Intermediate"), ("Intermediate", "Distal"))
    ]
    centre = {name for name, _, _ in _TRUNK}
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for name, parent, (x, y, z) in (*_SIDE, *fingers):
            rows.append((side + name, parent if parent in centre else side + parent, (sign * x, y, z)))
    children: dict[str, list[int]] = {}
    for place, (_, parent, _) in enumerate(rows):
        children.setdefault(parent, []).append(place)
    order, waiting = [], [0]
    while waiting:
        place = waiting.pop()
        order.append(rows[place])
        waiting += reversed(children.get(rows[place][0], []))
    return order
