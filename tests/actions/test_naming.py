"""Names that need more than a skeleton: which joint moves the figure is seen in its motion."""

from __future__ import annotations

import pytest

from mcml.formats import FORMATS
from mcml.language.elements import joint_names
from mcml.motion.carriers import first_moving
from mcml.testing import read
from mcml_service.storage.database import Database
from tests.builders import store

HEAD = """HIERARCHY
ROOT Root
{
\tOFFSET 0 0 0
\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
\tJOINT Hips
\t{
\t\tOFFSET 0 90 0
\t\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
\t\tJOINT LeftUpLeg
\t\t{
\t\t\tOFFSET 9 0 0
\t\t\tCHANNELS 3 Zrotation Xrotation Yrotation
\t\t\tJOINT LeftLeg
\t\t\t{
\t\t\t\tOFFSET 0 -40 0
\t\t\t\tCHANNELS 3 Zrotation Xrotation Yrotation
\t\t\t\tEnd Site
\t\t\t\t{
\t\t\t\t\tOFFSET 0 -40 0
\t\t\t\t}
\t\t\t}
\t\t}
\t}
}
MOTION
"""


def rig(root: float, hips: float, frames: int = 3, height: float = 90) -> bytes:
    """Joints that go so far along X from frame to frame. height: of the hips above the root."""
    rows = [f"{root * frame} 0 0 0 0 0 {hips * frame} {height} 0 0 0 0 0 0 0 0 0 0" for frame in range(frames)]
    head = HEAD.replace("OFFSET 0 90 0", f"OFFSET 0 {height} 0")
    return (head + f"Frames: {frames}\nFrame Time: 0.01\n" + "\n".join(rows) + "\n").encode()


OUTER = ["Root", "Hips", "left_up_leg", "left_low_leg"]
INNER = ["Root#2", "Root", "left_up_leg", "left_low_leg"]


@pytest.mark.parametrize(
    ("root", "hips", "height", "names"),
    [
        (0.0, 1.5, 0, INNER),
        (1.5, 0.0, 0, OUTER),
        (1.5, 0.25, 5, OUTER),
        (0.0, 0.0, 0, INNER),
        # A root on the floor moves the figure, but its height is not that of the pelvis.
        (1.5, 0.25, 90, INNER),
        (1.5, 0.0, 90, INNER),
    ],
)
def test_the_root_is_the_joint_at_the_hips_that_moves_the_figure(
    database: Database, root: float, hips: float, height: float, names: list[str]
) -> None:
    uuid = store(database, {"walk.bvh": rig(root, hips, height=height)})[0]
    with database.read() as tx:
        document = tx.heads.document(tx.documents.get(uuid))
    assert list(joint_names(document)) == names


def test_only_as_many_frames_are_read_as_needed() -> None:
    clip = read(FORMATS["bvh"], {"bvh": rig(0, 1.5, 40)})
    assert first_moving(clip, (0, 1)) == 1
    assert first_moving(clip, (0, 2)) is None
    moving = read(FORMATS["bvh"], {"bvh": rig(1.5, 0, 40)})
    broken = rig(1.5, 0, 60_000) + b"x\n"
    assert first_moving(moving, (0, 1)) == 0
    assert first_moving(read(FORMATS["bvh"], {"bvh": broken}), (0, 1)) == 0
