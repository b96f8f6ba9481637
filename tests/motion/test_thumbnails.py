"""Thumbnails: what is drawn is where the joints are, to a pixel; walkers stay on the spot while the ground goes by."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mcml.motion.hub import rest_of
from mcml.motion.landmarks.centres import body_names, centres_of, with_centres
from mcml.motion.landmarks.sizes import Sizes
from mcml.motion.markers import marker_skeleton
from mcml.motion.pictures import thumbnails
from mcml.motion.pictures.figures import Figure, farthest, figure_of, finite, marker_body_figure, view_of
from mcml.motion.pictures.thumbnails import busiest, draw, loop_times, poses_at, scrub_times
from mcml.motion.skeleton import Array, Convention, EndSite, Joint, Skeleton
from tests import thumbnails as mt1
from tests.motion.landmarks.standing import PLACES, STANDING
from tests.motion.landmarks.standing import SKELETON as MARKERS

FRONT = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]])
STICK = Figure((0, 1, 2), ((0, 1), (1, 2)), (0, 1, 2), 0)


def joint(name: str, parent: int, offset: tuple[float, float, float], *, tip: bool = False) -> Joint:
    sites = (EndSite(("0", "1", "0")),) if tip else ()
    x, y, z = map(repr, offset)
    return Joint(name, parent, name, Convention.LISTED, ("Rx",), "X", offset=(x, y, z), end_sites=sites)


def test_a_picture_is_where_the_points_are() -> None:
    rng = np.random.default_rng(0)
    poses = rng.uniform(-1, 1, (10, 3, 3)) * [40, 80, 20]
    found = mt1.read(draw(STICK, poses[:6], poses[6:], 1.5, FRONT))
    relative = poses - poses[:, :1] * [1, 0, 0]
    height = float(np.ptp(relative[..., 1]))
    x = (relative[..., 0] - relative[..., 0].min()) / height
    y = (relative[..., 1].max() - relative[..., 1]) / height
    drawn = np.concatenate([found.loop, found.scrub])
    assert np.abs(drawn - np.stack([x, y], axis=-1)).max() < 0.6 * max(1, found.aspect) / 255
    assert (found.seconds, found.face, found.markers) == (1.5, False, False)


def test_bones_are_drawn_from_the_farthest_on_with_their_sides() -> None:
    pose = np.array([[0, 0, 0], [0, 1, -9], [0, 2, 5]], dtype=float)
    found = mt1.read(draw(STICK, pose[None], pose[None], 0.0, FRONT))
    assert found.bones.tolist() == [[0, 1, 1, 0], [1, 2, 2, 63]]


def test_the_ground_goes_by_under_a_walker() -> None:
    steps = np.arange(40) * 11.0
    poses = np.tile(np.array([[0, 0, 0], [0, 50, 0], [20, 100.0, 0]]), (40, 1, 1))
    poses[..., 0] += steps[:, None]
    found = mt1.read(draw(STICK, poses[:32], poses[32:], 2.58, FRONT))
    assert np.ptp(found.loop, axis=0).max() == 0, "the body stays"
    way = steps[:32] / 100 / found.step
    assert np.array_equal(found.ground[:32], np.mod(np.rint(way), 256))
    assert found.ground[32] == 0


def test_the_loop_is_where_most_happens() -> None:
    positions = np.zeros((1000, 3, 3))
    positions[600:700, 2, 1] = np.sin(np.arange(100))
    start, end = busiest(positions, 1 / 24)
    assert 599 / 24 <= start < end <= 701 / 24
    assert end - start == pytest.approx(31 / 12)
    assert len(loop_times(STICK, start, end)) == 32
    assert busiest(positions[:25], 1 / 24) == (0.0, 1.0)
    assert loop_times(STICK, 0.0, 1.0).tolist() == np.linspace(0, 1, 13).tolist()
    assert loop_times(STICK, 0.0, 0.0).tolist() == [0.0]
    assert scrub_times(STICK, 1000, 41.6)[-1] == 41.6


def test_poses_lie_on_lines_between_those_that_there_are() -> None:
    positions = np.arange(5.0)[:, None, None] * np.ones((1, 2, 3))
    assert poses_at(positions, 0.5, np.array([0.0, 0.25, 1.9, 9.0]))[:, 0, 0].tolist() == [0.0, 0.5, 3.8, 4.0]


def test_fingers_go_first_then_tips_then_short_bones() -> None:
    joints = [joint("Root", -1, (0, 0, 0))]
    joints += [joint(f"spine {n}", n - 1, (0, float(40 - n), 0)) for n in range(1, 31)]
    joints += [joint("left_hand", 30, (9, 0, 0)), joint("left_finger_two", 31, (50, 0, 0), tip=True)]
    skeleton = Skeleton(tuple(joints))
    found = figure_of(skeleton, rest_of(skeleton), 0)
    assert (len(found.points), found.root) == (32, 0)
    assert 32 not in found.points, "the finger"
    assert found.points == tuple(range(32)), "and its tip, but no more"
    more = Skeleton((*joints[:31], *(joint(f"rib {n}", 5, (0.1 * n, 0, 0)) for n in range(1, 11))))
    kept = figure_of(more, rest_of(more), 0)
    assert {more.joints[point].name for point in kept.points} >= {f"spine {n}" for n in range(1, 31)}
    assert kept.bones[-1][0] == 5, "what hung on one that went hangs on the one above"


def test_a_root_that_only_stands_in_the_world_is_not_drawn() -> None:
    skeleton = Skeleton((joint("world", -1, (0, 0, 0)), joint("Hips", 0, (0, 9, 0)), joint("Head", 1, (0, 9, 0))))
    found = figure_of(skeleton, rest_of(skeleton), 1)
    assert (found.points, found.bones, found.root) == ((1, 2), ((0, 1),), 0)


def test_targets_and_twist_bones_are_not_drawn() -> None:
    joints = (
        joint("Root", -1, (0, 0, 0)),
        joint("Head", 0, (0, 9, 0), tip=True),
        replace(joint("ik_hand_root", 0, (0, 0, 0)), role="control"),
        replace(joint("ik_hand_l", 2, (5, 0, 0), tip=True), role="control"),
    )
    skeleton = Skeleton(joints)
    assert figure_of(skeleton, rest_of(skeleton), 0).points == (0, 1, 4)


def test_bodies_are_seen_from_their_left_front() -> None:
    names = {"Root": (0, 0, 0), "left_up_leg": (10, 0, 0), "right_up_leg": (-10, 0, 0), "Head": (0, 90, 0)}
    joints = tuple(joint(name, min(n, 1) - 1, (0, 0, 0)) for n, name in enumerate(names))
    skeleton = Skeleton(joints)
    pose: Array = np.array(list(names.values()), dtype=float)
    view = view_of(skeleton, figure_of(skeleton, rest_of(skeleton), 0), pose, np.array([0.0, 1, 0]))
    np.testing.assert_allclose(view @ view.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(view[2], [np.sin(thumbnails_turn()), 0, np.cos(thumbnails_turn())], atol=1e-12)
    assert (pose @ view[0])[1] > (pose @ view[0])[2], "its left is to the right of who looks at it"


def thumbnails_turn() -> float:
    return float(np.radians(35))


def test_points_as_far_apart_as_can_be() -> None:
    points = np.array([[0, 0, 0], [0.1, 0, 0], [10, 0, 0], [5, 0, 0]], dtype=float)
    assert sorted(farthest(points, 3)) == [0, 2, 3]
    assert farthest(points, 9) == [0, 1, 2, 3]


def test_gaps_are_filled_from_the_sides() -> None:
    values = np.full((5, 1, 3), np.nan)
    values[1], values[3] = 1, 3
    assert finite(values)[:, 0, 0].tolist() == [1, 1, 1, 3, 3]
    assert finite(np.full((2, 1, 3), np.nan)).tolist() == [[[0, 0, 0]]] * 2


@pytest.mark.parametrize("size", [0.0, 1e-300, 1e300, np.inf])
def test_any_numbers_make_a_picture(size: float) -> None:
    with np.errstate(all="ignore"):
        poses = finite(np.random.default_rng(1).normal(0, 1, (4, 3, 3)) * size)
    with np.errstate(all="raise", under="ignore"):
        assert mt1.read(draw(STICK, poses, poses, 1.0, FRONT)).loop.shape == (4, 3, 2)
    assert thumbnails.MAGIC == b"MT1"


def test_markers_of_a_person_are_drawn_as_a_figure() -> None:
    points = with_centres(centres_of(MARKERS), PLACES.repeat(4, axis=0), Sizes(0.001))
    figure = marker_body_figure(MARKERS, points)
    assert figure is not None
    names = body_names(MARKERS)
    lines = {(names[figure.points[start]], names[figure.points[end]]) for start, end in figure.bones}
    assert {("Root", "left_up_leg"), ("left_low_leg", "left_foot"), ("left_up_arm", "left_low_arm")} <= lines
    assert ("right_low_arm", "right_hand") not in lines, "that arm has no markers"
    assert (figure.markers, figure.root) == (False, 0)
    sides = dict(zip((names[point] for point in figure.points), figure.sides, strict=True))
    assert (sides["left_foot"], sides["right_foot"], sides["Root"]) == (1, 2, 0)
    # It is seen from its left front, as skeletons are.
    toward = view_of(MARKERS, figure, points[0], np.array([0.0, 0.0, 1.0]))[2]
    assert (toward[:2] > 0).all()
    # A leg that is not seen in most poses leaves points alone.
    points[:3, names.index("left_foot")] = np.nan
    assert marker_body_figure(MARKERS, points) is None


def test_two_people_are_two_figures() -> None:
    skeleton = marker_skeleton([f"{who}:{name}" for who in ("Anna", "Bea") for name in STANDING])
    places = np.concatenate([PLACES, PLACES + np.array([1000, 0, 0])], axis=1)
    figure = marker_body_figure(skeleton, with_centres(centres_of(skeleton), places, Sizes(0.001)))
    assert figure is not None
    assert figure.root is None
    names = body_names(skeleton)
    whose = [{names[figure.points[place]].partition(":")[0] for place in bone} for bone in figure.bones]
    assert all(len(each) == 1 for each in whose)
    assert {"Anna", "Bea"} == set.union(*whose)
