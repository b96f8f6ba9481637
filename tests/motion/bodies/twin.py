"""Questions about motion answered frame by frame, joint by joint, with plain numbers: the slow twin of the fast way.

Own forward kinematics with matrices, own formulas. Only text becomes numbers by the service's readers. Positions are
whole steps, as the service rounds them; None where one is not known.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache

import numpy as np

from mcml.motion.bodies.calibration import Calibration
from mcml.motion.clip import ClipStream
from tests.motion.bodies.twin_kinematics import Matrix, frame_poses, rest_pose

Place = tuple[int, int, int] | None
NAN = math.nan


class Twin:
    """A document. places: of every joint, in every frame."""

    def __init__(self, places: Mapping[str, list[Place]], frame_time: float | None, calibration: Calibration) -> None:
        self.places = {name: list(item) for name, item in places.items()}
        self.frames = len(next(iter(places.values())))
        self.time = frame_time
        self.calibration = calibration
        for item in self.places.values():
            item[: calibration.skipped] = [None] * calibration.skipped
        self.up = np.zeros(3)
        self.up["XYZ".index(calibration.up[-1])] = -1.0 if calibration.up[0] == "-" else 1.0
        self.metres = NAN if calibration.metres is None else calibration.metres * calibration.step
        around = 0.0 if frame_time is None else 0.05 / frame_time
        self.far = max(2, math.floor(around + 0.01))

    @classmethod
    def of(cls, clip: ClipStream, calibration: Calibration, most: int | None = None) -> Twin:
        """The first frames of a clip without missing samples, all by default."""
        frames, (_, still) = frame_poses(clip)[:most], rest_pose(clip)
        places: dict[str, list[Place]] = {}
        for name in clip.head.skeleton.names:
            rows = [frame[name] / calibration.step for frame, _ in frames]
            places[name] = [(round(float(x)), round(float(y)), round(float(z))) for x, y, z in rows]
        for bone, axis in calibration.bones.items():
            rows = [10_000 * axes[bone] @ still[bone].T @ np.array(axis.left) for _, axes in frames]
            places[f"{bone} left"] = [(round(float(x)), round(float(y)), round(float(z))) for x, y, z in rows]
        return cls(places, clip.head.seconds_per_frame(), calibration)

    def at(self, joint: str, frame: int) -> np.ndarray | None:
        place = self.places[joint][frame] if joint in self.places else None
        return None if place is None else np.array(place, dtype=float)

    def line(self, start: str, end: str, frame: int) -> np.ndarray | None:
        one, other = self.at(start, frame), self.at(end, frame)
        return None if one is None or other is None else other - one

    def values(self, name: str, arguments: tuple[str, ...]) -> list[float]:
        if name in ("heading", "contact"):
            return getattr(self, name)(*arguments)
        return [getattr(self, name)(frame, *arguments) for frame in range(self.frames)]

    def unit(self, frame: int) -> float:
        return NAN if self.calibration.metres is None else self.calibration.metres

    def leg(self, frame: int) -> float:
        return NAN if self.calibration.leg is None else self.calibration.leg * self.unit(frame)

    def second(self, frame: int) -> float:
        return NAN if self.time is None else frame * self.time

    def height(self, frame: int, joint: str) -> float:
        place = self.at(joint, frame)
        if place is None or self.calibration.floor is None:
            return NAN
        return (float(place @ self.up) * self.calibration.step - self.calibration.floor) * self.unit(frame)

    def left(self, frame: int) -> np.ndarray | None:
        """Where left is, on the level; none for hips within 5.7 degrees of upright."""
        across = self.line("right_up_leg", "left_up_leg", frame)
        if across is None or not across.any():
            return None
        level = across - (across @ self.up) * self.up
        flat = math.hypot(*level)
        return level / flat if flat > 0.1 * math.hypot(*across) else None

    def position(self, frame: int, joint: str, axis: str, origin: str | None = None) -> float:
        place = self.at(joint, frame) if origin is None else self.line(origin, joint, frame)
        left = self.left(frame)
        if place is None or (left is None and axis in ("left", "front")):
            return NAN
        if axis in "xyz":
            return float(place["xyz".index(axis)]) * self.metres
        if axis == "up":
            return float(place @ self.up) * self.metres
        assert left is not None
        return float(place @ (left if axis == "left" else np.cross(left, self.up))) * self.metres

    def distance(self, frame: int, one: str, other: str) -> float:
        line = self.line(one, other, frame)
        return NAN if line is None else math.hypot(*line) * self.metres

    def tilt(self, frame: int, one: str, other: str) -> float:
        line = self.line(one, other, frame)
        return _between(line, self.up)

    def corner(self, frame: int, one: str, middle: str, other: str) -> float:
        return _between(self.line(middle, one, frame), self.line(middle, other, frame))

    def moving(self, joint: str, relative: str | None) -> list[np.ndarray | None]:
        return [
            self.at(joint, frame) if relative is None else self.line(relative, joint, frame)
            for frame in range(self.frames)
        ]

    def parabola(self, values: list[np.ndarray | None], frame: int) -> tuple[np.ndarray | None, np.ndarray | None]:
        """First and second derivative, a frame."""
        own = values[frame]
        steps = [
            step
            for step in range(-self.far, self.far + 1)
            if 0 <= frame + step < len(values) and values[frame + step] is not None
        ]
        if own is None or len(steps) < 2:
            return None, None
        away = np.array([values[frame + step] - own for step in steps])
        if len(steps) == 2:
            return (away[1] - away[0]) / (steps[1] - steps[0]), None
        design = np.array([[1.0, step, step * step] for step in steps])
        fit = np.linalg.lstsq(design, away, rcond=None)[0]
        return fit[1], 2 * fit[2] if len(steps) == 2 * self.far + 1 else None

    def speed(self, frame: int, joint: str, relative: str | None = None) -> float:
        slope = None if self.time is None else self.parabola(self.moving(joint, relative), frame)[0]
        return NAN if slope is None or self.time is None else math.hypot(*slope) / self.time * self.metres

    def acceleration(self, frame: int, joint: str, relative: str | None = None) -> float:
        bend = None if self.time is None else self.parabola(self.moving(joint, relative), frame)[1]
        return NAN if bend is None or self.time is None else math.hypot(*bend) / self.time**2 * self.metres

    def heading(self) -> list[float]:
        """Turned to the left from the axis that comes after the upward one, X Y Z X; as near to the last as can be."""
        zero = np.eye(3)[(("XYZ".index(self.calibration.up[-1])) + 1) % 3]
        beside = np.cross(self.up, zero)
        found, last = [], None
        for frame in range(self.frames):
            left = self.left(frame)
            if left is None:
                found.append(NAN)
                continue
            ahead = np.cross(left, self.up)
            angle = math.degrees(math.atan2(ahead @ beside, ahead @ zero))
            while last is not None and angle - last > 180:
                angle -= 360
            while last is not None and angle - last < -180:
                angle += 360
            last = angle
            found.append(angle)
        return found

    def contact(self, joint: str) -> list[float]:
        """Low and slow to begin, neither high nor fast to go on, both ways; for 0.05 s at least."""
        c = self.calibration
        places = self.moving(joint, None)
        if c.leg is None or c.floor is None or self.time is None or all(place is None for place in places):
            return [NAN] * self.frames
        ground = c.floor / c.step
        if not joint.endswith("toes"):
            lowest = float(np.percentile([float(place @ self.up) for place in places if place is not None], 5))
            ground = min(max(lowest, ground), ground + 0.15 * c.leg / c.step)
        begins, stays = [], []
        for frame, place in enumerate(places):
            slope = self.parabola(places, frame)[0]
            if place is None or slope is None:
                begins.append(False)
                stays.append(False)
                continue
            high = (float(place @ self.up) - ground) * c.step / c.leg
            fast = math.hypot(*slope) / self.time * c.step / c.leg
            begins.append(high < 0.06 and fast < 0.35)
            stays.append(high < 0.12 and fast < 0.7)
        stands = list(begins)
        for order in (range(1, self.frames), range(self.frames - 2, -1, -1)):
            for frame in order:
                before = frame - 1 if order.step > 0 else frame + 1
                stands[frame] = stands[frame] or (stands[before] and stays[frame])
        frame = 0
        while frame < self.frames:
            end = frame
            while end < self.frames and stands[end]:
                end += 1
            if end - frame < max(2, math.ceil(0.05 / self.time)):
                stands[frame:end] = [False] * (end - frame)
            frame = max(end, frame + 1)
        return [NAN if place is None else float(flag) for place, flag in zip(places, stands, strict=True)]

    def trunk(self, frame: int, right: str, left: str) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        neck = self.at(next((n for n in ("neck2", "neck1") if n in self.places), "Head"), frame)
        one, other = self.at("left_up_leg", frame), self.at("right_up_leg", frame)
        across = self.line(right, left, frame)
        if neck is None or one is None or other is None or across is None:
            return None
        up = neck - (one + other) / 2
        up = up / math.hypot(*up)
        side = across - (across @ up) * up
        side = side / math.hypot(*side)
        return side, up, np.cross(side, up)

    def pelvis(self, frame: int, *, upright: bool) -> Matrix | None:
        """Columns on, left and up: up to the lowest joint of the spine, or the root; anywhere if it does not matter."""
        across = self.line("right_up_leg", "left_up_leg", frame)
        one, other = self.at("left_up_leg", frame), self.at("right_up_leg", frame)
        top = self.at(next(n for n in ("waist", "torso7", "Root") if n in self.places), frame)
        if across is None or one is None or other is None or (upright and top is None):
            return None
        up = top - (one + other) / 2 if upright and top is not None else np.array([0.3, 0.5, -0.7])
        return _axes(up, across, keep_left=True)

    def bone(self, frame: int, upper: str, lower: str) -> Matrix | None:
        along, left = self.line(lower, upper, frame), self.at(f"{upper} left", frame)
        return None if along is None or left is None else _axes(along, left, keep_left=False)

    def clinical(self, frame: int, side: str, part: str, movement: str) -> float:
        """By the Cardan angles of one matrix: about left, on and up, one after the other."""
        k = -1.0 if side == "right" else 1.0
        zeros = self.calibration.zeros
        thigh = self.bone(frame, f"{side}_up_leg", f"{side}_low_leg")
        pelvis = self.pelvis(frame, upright=part == "pelvis" or movement == "flexion")
        if part == "ankle":
            corner = self.corner(frame, f"{side}_low_leg", f"{side}_foot", f"{side}_toes")
            return 90.0 - corner - zeros.get(f"{side}_foot", 0.0)
        if part == "pelvis":
            if pelvis is None:
                return NAN
            return math.degrees(math.atan2(-pelvis[:, 0] @ self.up, pelvis[:, 2] @ self.up)) - zeros.get("pelvis", 0.0)
        if part == "hip" and movement != "internal-rotation":
            # However the thigh is turned.
            line = self.line(f"{side}_low_leg", f"{side}_up_leg", frame)
            thigh = None if line is None else _axes(line, np.array([0.3, 0.5, -0.7]), keep_left=False)
        below = thigh if part == "hip" else self.bone(frame, f"{side}_low_leg", f"{side}_foot")
        if part == "knee" and movement != "internal-rotation":
            line = self.line(f"{side}_foot", f"{side}_low_leg", frame)
            below = None if line is None else _axes(line, np.array([0.3, 0.5, -0.7]), keep_left=False)
        above = pelvis if part == "hip" else thigh
        if above is None or below is None:
            return NAN
        r = above.T @ below
        alpha, beta = math.degrees(math.atan2(r[0, 2], r[2, 2])), math.degrees(math.asin(-r[1, 2]))
        gamma = math.degrees(math.atan2(r[1, 0], r[1, 1]))
        return {
            ("hip", "flexion"): -alpha - zeros.get("pelvis", 0.0),
            ("hip", "adduction"): -k * beta,
            ("hip", "internal-rotation"): -k * gamma,
            ("knee", "flexion"): alpha,
            ("knee", "varus"): -k * beta,
            ("knee", "internal-rotation"): -k * gamma,
        }[part, movement]

    def named(self, frame: int, name: str) -> float:
        side = name.partition("-")[0] if name.startswith(("left-", "right-")) else ""
        part, _, movement = name.removeprefix(f"{side}-").partition("-")
        opposites = {"extension": "flexion", "abduction": "adduction", "external-rotation": "internal-rotation",
                     "valgus": "varus", "plantarflexion": "dorsiflexion"}  # fmt: skip
        signed = part == "knee" and f"{side}_up_leg left" in self.places
        if part in ("hip", "ankle") or movement in ("tilt", "varus", "valgus") or "ternal" in movement or signed:
            degrees = self.clinical(frame, side, part, opposites.get(movement, movement))
            return -degrees if movement in opposites else degrees
        outwards = -1.0 if side == "right" else 1.0
        if movement in ("extension", "adduction", "horizontal-adduction", "plantarflexion", "left-lateral-flexion",
                        "right-rotation"):  # fmt: skip
            back = {"extension": "flexion", "plantarflexion": "dorsiflexion", "right-rotation": "left-rotation",
                    "left-lateral-flexion": "right-lateral-flexion"}  # fmt: skip
            opposite = back.get(movement, movement.replace("adduction", "abduction"))
            return -self.named(frame, "-".join(word for word in (side, part, opposite) if word))
        if part in ("knee", "elbow"):
            hand = f"{side}_wrist" if f"{side}_wrist" in self.places else f"{side}_hand"
            ends = {"knee": ("up_leg", "low_leg", "foot"), "elbow": ("up_arm", "low_arm", "")}[part]
            last = f"{side}_{ends[2]}" if ends[2] else hand
            return 180.0 - self.corner(frame, f"{side}_{ends[0]}", f"{side}_{ends[1]}", last)
        if part == "foot":
            return 90.0 - self.corner(frame, f"{side}_low_leg", f"{side}_foot", f"{side}_toes")
        if part in ("arm", "leg"):
            axes = self.trunk(frame, f"right_up_{part}", f"left_up_{part}")
            bone = self.line(f"{side}_up_{part}", f"{side}_low_{part}", frame)
            if axes is None or bone is None:
                return NAN
            left, up, on = axes
            if movement == "flexion":
                return _swing(bone, -up, on, 0.35)
            out = left * outwards
            return _swing(bone, -up, out, 0.35) if movement == "abduction" else _swing(bone, on, out, 0.7)
        left = self.left(frame)
        if part == "pelvis":
            across = self.line("right_up_leg", "left_up_leg", frame)
            if across is None:
                return NAN
            return math.degrees(math.atan2(across @ self.up, math.hypot(*(across - (across @ self.up) * self.up))))
        hips, shoulders = (self.trunk(frame, f"right_up_{limb}", f"left_up_{limb}") for limb in ("leg", "arm"))
        if movement == "left-rotation":
            if hips is None or shoulders is None:
                return NAN
            turn = np.cross(hips[0], shoulders[0]) @ hips[1]
            return math.degrees(math.atan2(turn, hips[0] @ shoulders[0]))
        if hips is None or left is None:
            return NAN
        on = np.cross(left, self.up)
        return _swing(hips[1], self.up, on if movement == "flexion" else -left, 0.35)

    def features(self, frame: int, joints: tuple[str, ...]) -> np.ndarray:
        """(20, 3): the pose turned back by its heading, so that it faces along one axis."""
        zero = np.eye(3)[(("XYZ".index(self.calibration.up[-1])) + 1) % 3]
        left = self.left(frame)
        found = np.full((len(joints), 3), NAN)
        if left is None or self.calibration.leg is None:
            return found
        ahead = np.cross(left, self.up)
        angle = math.atan2(ahead @ np.cross(self.up, zero), ahead @ zero)
        c, s = math.cos(-angle), math.sin(-angle)
        for index, joint in enumerate(joints):
            v = self.line("Root", joint, frame)
            if v is not None:
                # Rodrigues' formula, about the upward axis.
                v = v * c + np.cross(self.up, v) * s + self.up * (self.up @ v) * (1 - c)
                found[index] = np.array([v @ np.cross(self.up, zero), v @ self.up, v @ zero])
        return found * self.calibration.step / self.calibration.leg


def _between(one: np.ndarray | None, other: np.ndarray | None) -> float:
    if one is None or other is None or not one.any() or not other.any():
        return NAN
    one, other = one / math.hypot(*one), other / math.hypot(*other)
    # Kahan's formula.
    return math.degrees(2 * math.atan2(math.hypot(*(one - other)), math.hypot(*(one + other))))


def _swing(bone: np.ndarray, start: np.ndarray, towards: np.ndarray, away: float) -> float:
    axis = np.cross(start, towards)
    shadow = bone - (bone @ axis) * axis
    if math.hypot(*shadow) <= away * math.hypot(*bone):
        return NAN
    angle = _between(shadow, start)
    if shadow @ towards < 0:
        angle = -angle
    return angle + 360 if angle < -90 else angle


def pose_distance(one: np.ndarray, other: np.ndarray) -> float:
    squares = [float(((a - b) ** 2).sum()) for a, b in zip(one, other, strict=True)]
    known = [square for square in squares if not math.isnan(square)]
    return math.sqrt(sum(known) / len(known)) if len(known) >= 10 else NAN


def motion_distance(features: list[np.ndarray], motion: list[np.ndarray], end: int) -> float:
    """The least mean over all ways to give each frame of the motion a frame of the stretch: after two of the motion for
    one of the stretch, or one for two, comes a step of one for one or another such."""

    @cache
    def apart(i: int, j: int) -> float:
        found = pose_distance(features[j], motion[i])
        return math.inf if math.isnan(found) else found

    @cache
    def least(i: int, j: int) -> float:
        if i < 0 or j < 0:
            return math.inf
        if i == 0:
            return apart(0, j)
        ways = [least(i - 1, j - 1), least(i - 1, j - 2)]
        if i >= 2:
            ways.append(least(i - 2, j - 1) + apart(i - 1, j))
        return min(ways) + apart(i, j)

    found = least(len(motion) - 1, end) / len(motion)
    return found if math.isfinite(found) else NAN


def _axes(up: np.ndarray, left: np.ndarray, *, keep_left: bool) -> Matrix:
    """Columns on, left and up; the one that is not kept is made perpendicular."""
    y, z = left / math.hypot(*left), up / math.hypot(*up)
    if keep_left:
        z = z - (z @ y) * y
        z = z / math.hypot(*z)
    else:
        y = y - (y @ z) * z
        y = y / math.hypot(*y)
    return np.stack([np.cross(y, z), y, z], axis=1)
