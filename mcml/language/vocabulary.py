"""The names of `mcml.dtd`, and the parts of its content models that the code needs.

`tests/mcml/test_vocabulary.py` compares this file with the DTD.
"""

from __future__ import annotations

from typing import Final

from mcml.motion.skeleton import CHANNELS

LANGUAGE_VERSION: Final = "1.0"
PUBLIC_NAME: Final = "mcml.dtd"
"""The only system identifier a document may give."""

MCML: Final = "mcml"
HEADER: Final = "header"
ROOT: Final = "root"
SKELETON: Final = "skeleton"
MOTION: Final = "motion"

UNITS: Final = "units"
NUM_SEGMENTS: Final = "num_segments"
NUM_FRAMES: Final = "num_frames"
DATAFRAME_RATE: Final = "dataframe_rate"
DESCRIPTION: Final = "description"
PROPERTY: Final = "property"
SOURCE: Final = "source"
SECTION: Final = "section"
COMMENT: Final = "comment"

BONE: Final = "bone"
END_SITE: Final = "end_site"
NAME: Final = "name"
DIRECTION: Final = "direction"
LENGTH: Final = "length"
POSITION: Final = "position"
AXIS: Final = "axis"
ORDER: Final = "order"
DOF: Final = "dof"
LIMITS: Final = "limits"
BODYMASS: Final = "bodymass"
COFMASS: Final = "cofmass"

FRAMES: Final = "frames"
FRAMETIME: Final = "frametime"
FRAME: Final = "frame"
MOTION_NAME: Final = "motion_name"
FRAME_BONE: Final = "frame_bone"

HEADER_LEAVES_BEFORE_UNITS: Final = ("filetype", "datatype", "filename", "version", "skeleton_name")
HEADER_LEAVES_AFTER_UNITS: Final = (
    NUM_SEGMENTS,
    NUM_FRAMES,
    DATAFRAME_RATE,
    "euler_rotation_order",
    "calibration_unit",
    "global_axis_of_gravity",
    "bone_length_axis",
    "scale_factor",
)
HEADER_LEAVES: Final = HEADER_LEAVES_BEFORE_UNITS + HEADER_LEAVES_AFTER_UNITS
"""Elements of the header that are `ClipHead.fields` of the same name, in their order (Table 2)."""

UNIT_ATTRIBUTES: Final = ("mass", "length", "angle")
"""Attributes of `units`; `ClipHead.fields` calls them units_mass, units_length, units_angle."""

CHANNEL_OF: Final = {channel.lower(): channel for channel in CHANNELS} | {"l": "SF"}
"""Channel by its lower-case spelling; ASF calls the stretch of a bone `l`."""

DEFAULT_ROOT_NAME: Final = "Root"
"""Name in frames of a root that states no name (Table 1, row 1)."""
