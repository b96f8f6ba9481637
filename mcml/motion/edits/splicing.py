"""Place a motion so that it continues another, and make the frames between them.

Arrays of the hub form, no files, no channels.

A body is placed by a rotation about the up axis and a shift along the ground, so that it keeps its facing and
direction. A transition bridges two poses: each side continues with its decreasing speed, and a weight with zero slope
at both ends (2 p^3 - 3 p^2 + 1, Kovar, Gleicher, Pighin 2002, sect. 3.2) leads from one to the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcml.motion.hub import walked
from mcml.motion.rotation_vectors import angle_between, from_vector, to_vector, twist
from mcml.motion.rotations import inverse, multiply, rotate
from mcml.motion.skeleton import Array, Skeleton

_ACROSS = 1e-9


@dataclass(frozen=True)
class Poses:
    """Frames in the hub form. translations: (n, J, 3). rotations: (n, J, 4). scales: (n, J)."""

    translations: Array
    rotations: Array
    scales: Array

    def __len__(self) -> int:
        return len(self.translations)

    def rows(self, start: int, end: int) -> Poses:
        """Frames from `start` up to before `end`."""
        return Poses(self.translations[start:end], self.rotations[start:end], self.scales[start:end])


@dataclass(frozen=True)
class Placement:
    """A turn about `up` by `angle` (radians), then a shift (3,): P' = Y P + d."""

    up: Array
    angle: float = 0.0
    shift: Array | None = None

    @property
    def is_nothing(self) -> bool:
        """Whether it is exactly the identity."""
        return self.shift is None

    def turn(self) -> Array:
        """(4,) the turn."""
        return from_vector(self.up * self.angle)


def joined_poses(parts: list[Poses]) -> Poses:
    """Frames one after the other."""
    return Poses(
        np.concatenate([part.translations for part in parts]),
        np.concatenate([part.rotations for part in parts]),
        np.concatenate([part.scales for part in parts]),
    )


def placed(skeleton: Skeleton, poses: Poses, carriers: tuple[int, ...], placement: Placement) -> Poses:
    """The frames with the body elsewhere. carriers: the joints that carry it; those above them stay where they are."""
    if placement.is_nothing:
        return poses
    assert placement.shift is not None
    translations, rotations = poses.translations.copy(), poses.rotations.copy()
    turn = placement.turn()
    positions, turned = walked(skeleton, poses.translations, poses.rotations)
    for joint in carriers:
        parent = skeleton.joints[joint].parent
        goal, faces = rotate(turn, positions[:, joint]) + placement.shift, multiply(turn, turned[:, joint])
        if parent < 0:
            translations[:, joint], rotations[:, joint] = goal, faces
            continue
        back = inverse(turned[:, parent])
        translations[:, joint] = rotate(back, goal - positions[:, parent])
        rotations[:, joint] = multiply(back, faces)
    return Poses(translations, rotations, poses.scales)


def going_on(
    skeleton: Skeleton, before: Poses, after: Poses, carriers: tuple[int, ...], up: Array, steps: float, points: bool
) -> Placement:
    """Place a motion so that it continues from another's last frame, `steps` frames later.

    It has the facing of the other: the rotation about `up` nearest to the one that takes one body to the other; for
    points (markers), the one that brings the clouds nearest. Between the two frames the body moves with the mean of its
    two speeds. Heights do not change.
    """
    where, faces = _carried(skeleton, before.rows(max(len(before) - 2, 0), len(before)), carriers)
    start, faced = _carried(skeleton, after.rows(0, 2), carriers)
    angle = (
        _nearest_turn(where[-1], start[0], up) if points else float(twist(multiply(faces[-1], inverse(faced[0])), up))
    )
    turn = from_vector(up * angle)
    middle, next_middle = where.mean(axis=1), rotate(turn, start.mean(axis=1))
    pace = (middle[-1] - middle[0] + next_middle[-1] - next_middle[0]) / 2
    shift = middle[-1] + steps * pace - next_middle[0]
    return Placement(up, angle, shift - (shift @ up) * up)


def _carried(skeleton: Skeleton, poses: Poses, carriers: tuple[int, ...]) -> tuple[Array, Array]:
    """Positions (n, C, 3) of the carriers, rotations (n, 4) of the first."""
    positions, turned = walked(skeleton, poses.translations, poses.rotations)
    return positions[:, list(carriers)], turned[:, carriers[0]]


def _nearest_turn(points: Array, others: Array, up: Array) -> float:
    """The angle about `up` by which points `others` (k, 3) come nearest to `points`, wherever they are."""
    one, two = points - points.mean(axis=0), others - others.mean(axis=0)
    flat, other = one - np.outer(one @ up, up), two - np.outer(two @ up, up)
    return float(np.arctan2(np.cross(other, flat).sum(axis=0) @ up, (other * flat).sum()))


def bridge(before: Poses, after: Poses, frames: int) -> Poses:
    """Return a number of frames between the last of one motion and the first of another, both in place.

    Rotations: each side continues by a third of its speed times the length, slerp between them. Translations: the cubic
    with the positions and speeds of both ends.
    """
    length = frames + 1
    part = np.arange(1, frames + 1) / length
    weight = part * part * (3 - 2 * part)
    first, pace = before.rotations[-1], _turning(before, -1)
    last, pace_after = after.rotations[0], _turning(after, 0)
    coast = length / 3 * (1 - (1 - part) ** 3)
    one = multiply(first, from_vector(coast[:, None, None] * pace))
    two = multiply(last, from_vector(-coast[::-1, None, None] * pace_after))
    rotations = steady_slerp(one, two, weight)
    ends = (
        before.translations[-1],
        after.translations[0],
        _step(before.translations, -1),
        _step(after.translations, 0),
    )
    translations = _cubic(*ends, length)
    scales = before.scales[-1] + weight[:, None] * (after.scales[0] - before.scales[-1])
    return Poses(translations, rotations, scales)


def crossfade(before: Poses, after: Poses) -> Poses:
    """Frames of two motions at the same times, (n) each, from one into the other."""
    part = np.arange(1, len(before) + 1) / (len(before) + 1)
    weight = part * part * (3 - 2 * part)
    share = weight[:, None, None]
    translations = before.translations + share * (after.translations - before.translations)
    scales = before.scales + share[..., 0] * (after.scales - before.scales)
    return Poses(translations, steady_slerp(before.rotations, after.rotations, weight), scales)


def inertialize(before: Poses, after: Poses, frames: int) -> Poses:
    """Return the first frames of a motion, with its difference to the end of another decaying to zero.

    The difference of poses and of speeds at the seam decays by a quintic with no speed and acceleration at its end
    (Bollo, "Inertialization", GDC 2018), rotations as vectors along their axes.
    """
    turn, turn_after = from_vector(_turning(before, -1)), from_vector(_turning(after, 0))
    now = to_vector(multiply(multiply(before.rotations[-1], turn), inverse(after.rotations[0])))
    earlier = to_vector(multiply(before.rotations[-1], inverse(multiply(after.rotations[0], inverse(turn_after)))))
    step, step_after = _step(before.translations, -1), _step(after.translations, 0)
    apart = before.translations[-1] - after.translations[0]
    turned = decay(now, now - earlier, frames)
    moved = decay(apart + step, step - step_after, frames)
    grown = decay(before.scales[-1] - after.scales[0], np.zeros_like(after.scales[0]), frames)
    head = after.rows(0, frames)
    return Poses(head.translations + moved, multiply(from_vector(turned), head.rotations), head.scales + grown)


def decay(values: Array, speeds: Array, frames: int) -> Array:
    """(frames, ...) the decay of values (...) from frame 0 on, to zero at frame `frames`.

    speeds: (...) a frame. With x0 the value and v0 its speed toward larger values, x(t) = A t^5 + B t^4 + C t^3 +
    a0/2 t^2 + v0 t + x0 up to t1 = min(frames, -5 x0 / v0), with a0 = max(0, (-8 v0 t1 - 20 x0) / t1^2) (Bollo 2018).
    """
    sign = np.where(values < 0, -1.0, 1.0)
    x0, v0 = np.abs(values), np.minimum(speeds * sign, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        t1 = np.where(v0 < 0, np.minimum(frames, -5 * x0 / v0), frames)
    t1 = np.where(t1 > 0, t1, 1.0)
    a0 = np.maximum(0.0, (-8 * v0 * t1 - 20 * x0) / t1**2)
    five = -(a0 * t1**2 + 6 * v0 * t1 + 12 * x0) / (2 * t1**5)
    four = (3 * a0 * t1**2 + 16 * v0 * t1 + 30 * x0) / (2 * t1**4)
    three = -(3 * a0 * t1**2 + 12 * v0 * t1 + 20 * x0) / (2 * t1**3)
    t = np.arange(frames).reshape(-1, *[1] * values.ndim)
    course = ((((five * t + four) * t + three) * t + a0 / 2) * t + v0) * t + x0
    decayed: Array = np.where((t < t1) & (x0 > 0), sign * course, 0.0)
    return decayed


def steady_slerp(start: Array, end: Array, weight: Array) -> Array:
    """slerp (n, J, 4) over a window of frames that goes the same way round in all of them: the shorter on the whole.

    start, end: (n, J, 4). weight: (n,), 0 at start. Frame by frame the shorter way might change sides in the middle.
    """
    start, end = _continuous(start), _continuous(end)
    end = end * np.where((start * end).sum(axis=(0, 2)) < 0, -1.0, 1.0)[:, None]
    angle = np.arccos(np.clip((start * end).sum(axis=2), -1.0, 1.0))
    sine = np.sin(angle)
    near = sine < _ACROSS
    divisor = np.where(near, 1.0, sine)
    share = weight[:, None]
    one = np.where(near, 1 - share, np.sin((1 - share) * angle) / divisor)
    two = np.where(near, share, np.sin(share * angle) / divisor)
    between = one[..., None] * start + two[..., None] * end
    unit: Array = between / np.linalg.norm(between, axis=2, keepdims=True)
    return unit


def _continuous(rotations: Array) -> Array:
    signs = np.where((rotations[1:] * rotations[:-1]).sum(axis=2) < 0, -1.0, 1.0)
    followed = rotations.copy()
    followed[1:] *= np.cumprod(signs, axis=0)[..., None]
    return followed


def _turning(poses: Poses, end: int) -> Array:
    """(J, 3) rotation vectors of the step at the last frame (-1) or from the first (0), in the joint's own axes."""
    if len(poses) < 2:
        return np.zeros((poses.rotations.shape[1], 3))
    one, two = (poses.rotations[-2], poses.rotations[-1]) if end else (poses.rotations[0], poses.rotations[1])
    return to_vector(multiply(inverse(one), two))


def _step(translations: Array, end: int) -> Array:
    if len(translations) < 2:
        return np.zeros_like(translations[0])
    step: Array = translations[-1] - translations[-2] if end else translations[1] - translations[0]
    return step


def _cubic(start: Array, end: Array, pace: Array, pace_after: Array, length: int) -> Array:
    part = (np.arange(1, length) / length)[:, None, None]
    straight = start + part * (end - start)
    one, two = length * pace - (end - start), length * pace_after - (end - start)
    curve: Array = straight + part * (1 - part) ** 2 * one - part**2 * (1 - part) * two
    return curve


def steps(skeleton: Skeleton, poses: Poses, carriers: tuple[int, ...]) -> tuple[float, float]:
    """The largest step from frame to frame: of a carrier in the world, of any joint's angle (radians)."""
    if len(poses) < 2:
        return 0.0, 0.0
    positions = walked(skeleton, poses.translations, poses.rotations)[0][:, list(carriers)]
    moved = np.linalg.norm(np.diff(positions, axis=0), axis=2).max()
    turned = angle_between(poses.rotations[:-1], poses.rotations[1:]).max()
    return float(moved), float(turned)


def jerks(skeleton: Skeleton, poses: Poses) -> Array:
    """(n - 3,) the largest third difference of the positions of joints, of each four frames."""
    if len(poses) < 4:
        return np.zeros(0)
    positions = walked(skeleton, poses.translations, poses.rotations)[0]
    largest: Array = np.nan_to_num(np.linalg.norm(np.diff(positions, 3, axis=0), axis=2)).max(axis=1)
    return largest
