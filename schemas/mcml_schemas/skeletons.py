"""Skeletons as those who draw or move them need them."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import DOCUMENT, PROJECT, shown

Side = Literal["left", "right", "centre"]

_CHANNELS = ["Tx", "Ty", "Tz", "Rz", "Rx", "Ry"]
_ROOT = {
    "address": "/mcml/root",
    "name": "Root",
    "source_name": "Hips",
    "mapped": True,
    "parent": -1,
    "side": "centre",
    "partner": 0,
    "offset": [0.0, 0.0, 0.0],
    "axes": [0.0, 0.0, 0.0, 1.0],
    "along": [0.0, 0.0, 0.0],
    "channels": _CHANNELS,
    "rotation_order": "ZXY",
    "convention": "listed",
    "translation": "absolute",
}
_HEAD = {
    **_ROOT,
    "address": "/mcml/skeleton/bone",
    "name": "Head",
    "source_name": "Head",
    "parent": 0,
    "partner": 1,
    "offset": [0.0, 52.25, 0.0],
    "channels": ["Rz", "Rx", "Ry"],
    "translation": "",
}
_PLATE = {"name": "1", "corners": [[40.0, 0.0, 60.0], [0.0, 0.0, 60.0], [0.0, 0.0, 0.0], [40.0, 0.0, 0.0]]}


class SkeletonBone(BaseModel):
    """A joint and the bone that starts there. Vectors are x y z in the document's unit, in the axes of the world at
    rest; quaternions x y z w."""

    address: str = Field(description="Of its element, a canonical XPath that finds it")
    name: str
    source_name: str = Field(description="As the file writes it")
    mapped: bool | None = Field(None, description="Whether the name is one of MCML's own")
    confidence: float | None = Field(None, description="Of the name if it is a guess, 0 to 1")
    role: str | None = Field(
        None, description="Purpose of a joint without a name of MCML's: jaw, left_eye, left_finger_one_2, twist, prop"
    )
    parent: int = Field(description="Index of the parent bone, -1 at a root; parents come first")
    side: Side = Field(description="By the names of the bone and of its partner")
    partner: int = Field(description="Index of the same bone of the other side; its own in the middle")
    offset: list[float] = Field(description="From the joint above to this one at rest; of a root from the origin")
    axes: list[float] = Field(description="Rotation at rest of the axes that the channels turn about")
    along: list[float] = Field(description="From the joint to the tip of its own bone, 0 where formats have none")
    channels: list[str] = Field(description="In the file's order; none: the bone never moves by itself")
    rotation_order: str = Field(description="Order of the rotations, as the convention means it")
    convention: Literal["listed", "fixed", "base", "marker", "shape"] = Field(description="How channels move a joint")
    translation: str = Field(description="Position channels replace the offset (absolute), or add to it (relative)")


class Tip(BaseModel):
    """The end of a chain: the end of a bone without children."""

    bone: int = Field(description="Index of the bone that it is the end of")
    name: str = Field(description="As the file names it, mostly nothing")
    offset: list[float] = Field(description="From the joint, in the axes of the world at rest")


class FloorPlate(BaseModel):
    """A force plate on the floor."""

    name: str | None = Field(
        description="Argument of the quantities `force` and `cop`; None where the file does not measure it there"
    )
    corners: list[list[float]] = Field(description="x y z of the four, in the unit and axes of the document")


class SkeletonView(BaseModel):
    """Everything about a document that does not change from frame to frame, for those who draw it."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "id": DOCUMENT,
                "name": "walk",
                "revision": 1,
                "frames": 1197,
                "frame_time": "0.0083333",
                "seconds_per_frame": 0.0083333,
                "markers": False,
                "unit": None,
                "likely_unit": "cm",
                "metres": 0.01,
                "up": None,
                "likely_up": "Y",
                "origin": [0.1886, 92.5, -3.25],
                "radians": 0.017453292519943295,
                "bones": [_ROOT, _HEAD],
                "tips": [{"bone": 1, "name": "", "offset": [0.0, 18.5, 0.0]}],
                "plates": [_PLATE],
                "columns": [*(f"Root.{part}" for part in _CHANNELS), "Head.Rz", "Head.Rx", "Head.Ry"],
            }
        )
    )

    id: str
    name: str
    revision: int
    frames: int
    frame_time: str | None = Field(None, description="Seconds a frame as the file writes them, where it does")
    seconds_per_frame: float | None = Field(None, description="None where neither file nor user stated a rate")
    markers: bool = Field(description="Whether bones are labelled points, which have no parents")
    unit: str | None = Field(None, description="Length unit, where one is stated")
    likely_unit: str | None = Field(None, description="The stated unit; else one in which the body would be a person")
    metres: float | None = Field(None, description="Of the likely unit")
    up: str | None = Field(None, description="Axis that points up, where one is stated")
    likely_up: str = Field(description="The stated axis; otherwise the upright axis of the body in the first frame")
    origin: list[float] = Field(description="Vector that `origin=subtract` subtracts from positions")
    radians: float = Field(description="Radians per unit of the frames' angles")
    bones: list[SkeletonBone] = Field(description="Parents before their children")
    tips: list[Tip]
    centres: list[str] = Field(
        [], description="Joints whose centres markers tell: quantities know them as they know bones"
    )
    lines: list[tuple[int, int]] = Field(
        [], description="Pairs of bones that lines connect in a drawing: markers of a person that is recognised"
    )
    plates: list[FloorPlate] = Field([], description="Force plates of a trial, as far as their corners are known")
    columns: list[str] = Field(description="BONE.CHANNEL of each number of a frame, in their order: that of the file")


class CharacterMesh(BaseModel):
    """A closed mesh of triangles, in the pose that it is bound in. Lengths are in the document's unit, in its axes.

    In a frame, with a joint at p and its rotation q (`space=positions` and `space=rotations`), bound at b with the
    rotation r, a vertex v that follows this joint alone is at p + q r⁻¹ (v − b). One that follows several is at the
    mean of such places, by its weights.
    """

    points: list[float] = Field(description="x y z of each vertex")
    triangles: list[int] = Field(description="Three vertices of each triangle, from 0, counterclockwise from outside")
    joints: list[int] = Field(description="Four joints that each vertex follows, as indices of the skeleton's bones")
    weights: list[float] = Field(description="How much it follows each of the four; together 1")
    bind_positions: list[list[float]] = Field(description="x y z of each joint in the pose that the mesh is bound in")
    bind_rotations: list[list[float]] = Field(description="Its rotation from the rest pose in the world, x y z w")
    normals: list[float] | None = Field(
        None, description="x y z of the unit normal of each vertex, of a file; None: the mean of its triangles"
    )
    colours: list[int] | None = Field(
        None, description="Red, green and blue of each vertex, 0 to 255 of sRGB; None: it has none of its own"
    )


class CharacterView(BaseModel):
    """The body that a document is drawn with, or why it has none.

    A `character` of the library moves on its own skeleton: joints of its mesh are those of `document`, in its unit and
    axes. `GET /documents/{id}/frames` with the same `character` has their positions and rotations in each frame.
    """

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "mesh": None,
                "reason": "A body needs joints that are not recognised: left_hand, right_hand.",
                "remedy": "Name its joints; until then it is shown as sticks.",
            }
        )
    )

    mesh: CharacterMesh | None = Field(None, description="None where joints that it needs are not recognised")
    reason: str | None = Field(None, description="Why there is no mesh")
    remedy: str | None = Field(None, description="How to get one")
    document: str | None = Field(None, description="The document of the character; None: the body of this project")
    revision: int | None = Field(None, description="Its revision")
    scale: float | None = Field(
        None, description="Lengths of the character in those of the document: divide by it to draw both together"
    )
    notes: list[str] = Field(
        [], description="Parts of the file that are left out, and limits of the retargeting, as text"
    )


class CharacterInfo(BaseModel):
    """A document whose uploaded file has a mesh with a skin."""

    document: str
    name: str
    project: str
    vertices: int = Field(description="Of all skinned meshes in the file")


class CharacterList(BaseModel):
    """Characters that clips can be shown on and exported with."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "items": [{"document": DOCUMENT, "name": "avatar", "project": PROJECT, "vertices": 18240}],
                "unread": 0,
            }
        )
    )

    items: list[CharacterInfo]
    unread: int = Field(
        description="Files imported by an earlier version that nobody has looked into yet: each answer looks into some"
    )
