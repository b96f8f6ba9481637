"""Left and right exchanged: a motion seen in a mirror.

With S the reflection at the plane between the sides and m(j) the joint of the other side, joints are at P'_j = S P_m(j)
with rotations Q'_j = S Q_m(j) X_j. X_j is a reflection too: it maps the bones of j at rest to those of m(j). In a rest
pose that is symmetric all X are one reflection, X = I - 2 n n^T, and L'_j = X L_m(j) X. Rigs whose left and right axes
differ (a right arm that points along -x, say) have an X for each joint. X_m(j) is the inverse of X_j, so that mirroring
twice is no change. A link that one side alone has (`sides_of`) stays at rest; its rotation is part of that of the joint
below.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mcml.motion.carriers import chain
from mcml.motion.clip import FrameBlock
from mcml.motion.frames import Edited, Rows, in_columns, present, remade
from mcml.motion.hub import HubReader, Rest, rest_of, walked
from mcml.motion.hub_writer import HubWriter
from mcml.motion.rotations import IDENTITY, from_matrix, multiply, rotate, to_matrix
from mcml.motion.sides import Sagittal, is_left, partners, sagittal, sides_of, turns
from mcml.motion.skeleton import Array, Convention, Skeleton
from mcml.motion.units import DEGREES, Reading

_ALIKE = np.cos(np.radians(15.0))
"""Two sides are never built quite alike: bones that miss their mirror image by less than this count as mirrored."""
_LYING = 0.1
"""Limit for lying bodies: if a body lies on its side, an upright plane cannot separate the sides."""
_PRIOR = 1e-7
"""Weight of a guess relative to bones: it decides where bones leave a rotation open."""


def mirrored(
    skeleton: Skeleton, block: FrameBlock, plane: Sagittal | None = None, up: str = "Y", reading: Reading = DEGREES
) -> Edited:
    """Frames of a clip with left and right exchanged, markers too; samples that were missing are missing there.

    plane: of the mirror; else the one between the sides of the first frame, upright. up: "X", "Y" or "Z". Raises
    ConversionError if the plane is not given and left and right are unknown.
    """
    columns = skeleton.columns()
    raw = in_columns(block, columns)
    hub = HubReader(skeleton, reading).read(block)
    if plane is None:
        plane = own_plane(
            skeleton, hub.translations[:1], hub.rotations[:1], np.eye(3)["XYZ".index(up.upper())], reading
        )
    other = partners(skeleton)
    writer = HubWriter(skeleton, reading)
    moved, turned = mirrored_poses(skeleton, writer.rest, hub.translations, hub.rotations, plane)
    values = writer.write(moved, turned, hub.scales[:, other])
    gone = ~present(raw, columns, len(skeleton))[:, other]
    for index, (joint, _) in enumerate(columns):
        values[gone[:, joint], index] = np.nan
    _carry_residuals(columns, other, raw, values)
    rows = np.arange(len(block), dtype=np.intp)
    return Edited(remade(block, columns, values, rows, block.ids, other), writer.shortfall)


def _carry_residuals(columns: tuple[tuple[int, int], ...], other: Rows, raw: Array, values: Array) -> None:
    place = {column: index for index, column in enumerate(columns)}
    for index, (joint, channel) in enumerate(columns):
        source = place.get((int(other[joint]), channel))
        if channel == 7 and source is not None:
            values[:, index] = raw[:, source]


def own_plane(
    skeleton: Skeleton, translations: Array, rotations: Array, up: Array, reading: Reading = DEGREES
) -> Sagittal:
    """Return the upright plane through the joint that carries the body, with its rotation in the first frame.

    translations: (n, J, 3), rotations: (n, J, 4) of the hub form. up: (3,). A mirrored clip has the same plane, also
    with very different sides. For points without a skeleton: the plane between their sides. Raises ConversionError if
    left and right are unknown.
    """
    positions, turned = walked(skeleton, translations[:1], rotations[:1])
    found = sagittal(skeleton, positions[0], up)
    if all(joint.convention is Convention.MARKER for joint in skeleton.joints):
        return found
    rest = rest_of(skeleton, reading)
    joint = chain(skeleton, skeleton.roots[0])[-1]
    # In ASF the root stands where the hips do, and another joint at that place may have their rotations.
    while len(skeleton.children(joint)) == 1 and not rest.offsets[skeleton.children(joint)[0]].any():
        joint = skeleton.children(joint)[0]
    frame = side_frames(skeleton, rest, partners(skeleton), _reflection(found.normal))[joint]
    normal = to_matrix(turned[0, joint]) @ np.linalg.eigh(frame)[1][:, 0]
    normal = normal - (normal @ up) * up
    length = float(np.linalg.norm(normal))
    if length < _LYING:
        return found
    return Sagittal(normal / length, positions[0, joint])


def mirrored_poses(
    skeleton: Skeleton, rest: Rest, translations: Array, rotations: Array, plane: Sagittal
) -> tuple[Array, Array]:
    """Translations (n, J, 3) and rotations (n, J, 4) of the hub form, mirrored. Bones keep their own lengths."""
    other = partners(skeleton)
    mirror = _reflection(plane.normal)
    sides = side_frames(skeleton, rest, other, mirror)
    shift = plane.point - mirror @ plane.point
    carried = {joint for root in skeleton.roots for joint in chain(skeleton, root)[1:]}
    links = sides_of(skeleton).links
    moved, turned = np.empty_like(translations), np.empty_like(rotations)
    for index, joint in enumerate(skeleton.joints):
        partner = int(other[index])
        if index in links:
            moved[:, index], turned[:, index] = rest.offsets[index], IDENTITY
            continue
        offset, translation, rotation = rest.offsets[partner], translations[:, partner], rotations[:, partner]
        link = skeleton.joints[partner].parent
        while link in links:
            offset = rest.offsets[link] + offset
            translation = translations[:, link] + rotate(rotations[:, link], translation)
            rotation = multiply(rotations[:, link], rotation)
            link = skeleton.joints[link].parent
        if joint.parent < 0:
            moved[:, index] = translation @ mirror.T + shift
            above = mirror
        else:
            above = sides[joint.parent].T
            if index in carried:
                moved[:, index] = translation @ above.T
            else:
                moved[:, index] = rest.offsets[index] + (translation - offset) @ above.T
        turned[:, index] = from_matrix(above @ to_matrix(rotation) @ sides[index])
    return moved, turned


def side_frames(skeleton: Skeleton, rest: Rest, other: Rows, mirror: Array) -> Array:
    """X (J, 3, 3) of each joint; see above. mirror: (3, 3), S, for fixed joints above the body."""
    frames = np.empty((len(skeleton), 3, 3))
    if all(joint.convention is Convention.MARKER for joint in skeleton.joints):
        frames[:] = mirror
        return frames
    links = sides_of(skeleton).links
    general = _reflection(_rest_normal(skeleton, rest, other))
    guesses: dict[int, Array] = {}
    carrying = {joint for root in skeleton.roots for joint in chain(skeleton, root)[:-1]}
    for index, joint in enumerate(skeleton.joints):
        partner = int(other[index])
        guess = guesses.get(joint.parent, general)
        if index in carrying:
            frames[index], guesses[index] = mirror, general
            continue
        if index in links or (joint.parent >= 0 and not turns(skeleton, index)):
            # It does not turn, so it is in the mirror as the joint that it hangs from.
            frames[index] = guess
        elif partner < index:
            frames[index] = frames[partner].T
        else:
            bones, images = _bones(skeleton, rest, other, index)
            frames[index] = _side_frame(bones, images, guess, partner == index)
        guesses[index] = frames[index]
    return frames


def _rest_normal(skeleton: Skeleton, rest: Rest, other: Rows) -> Array:
    """The direction to the left at rest, an axis of the world if it is near one; X if there are no sides."""
    positions = rest.offsets.copy()
    across = np.zeros(3)
    for index, joint in enumerate(skeleton.joints):
        if joint.parent >= 0:
            positions[index] += positions[joint.parent]
    for index, partner in enumerate(other):
        if partner != index and is_left(skeleton, index, int(partner)):
            across += positions[index] - positions[partner]
    length = float(np.linalg.norm(across))
    if not length:
        return np.array([1.0, 0.0, 0.0])
    axis = np.eye(3)[int(np.argmax(np.abs(across)))]
    return axis if abs(float(across @ axis)) > _ALIKE * length else across / length


def _bones(skeleton: Skeleton, rest: Rest, other: Rows, index: int) -> tuple[Array, Array]:
    """Unit vectors (k, 3) from a joint to its children and tips at rest, and those from its partner to theirs."""
    partner = int(other[index])
    mine_below, theirs_below = _carried_vectors(skeleton, rest, index), _carried_vectors(skeleton, rest, partner)
    shared = [child for child in mine_below if int(other[child]) in theirs_below]
    # What hangs on the middle and is of no side, such as a helper of one thigh, need not be its own image.
    sided = [child for child in shared if other[child] != child] if partner == index else []
    pairs = [(mine_below[child], theirs_below[int(other[child])]) for child in sided or shared]
    mine = [vector for joint, vector in rest.tips if joint == index]
    theirs = [vector for joint, vector in rest.tips if joint == partner]
    if len(mine) == len(theirs):
        pairs += list(zip(mine, theirs, strict=True))
    lengths = [(np.linalg.norm(one), np.linalg.norm(two)) for one, two in pairs]
    longest = max((max(pair) for pair in lengths), default=0.0)
    kept = [(one / a, two / b) for (one, two), (a, b) in zip(pairs, lengths, strict=True) if min(a, b) > 1e-3 * longest]
    if not kept:
        return np.zeros((0, 3)), np.zeros((0, 3))
    return np.array([one for one, _ in kept]), np.array([two for _, two in kept])


def _carried_vectors(skeleton: Skeleton, rest: Rest, index: int) -> dict[int, Array]:
    """Vectors (3,) from a joint to its children at rest; those that do not turn count as far as their own children."""
    found: dict[int, Array] = {}
    links = sides_of(skeleton).links
    for child in skeleton.children(index):
        leads_on = child in links or not turns(skeleton, child)
        below = _carried_vectors(skeleton, rest, child) if leads_on else {}
        below = below or {child: np.zeros(3)}
        found |= {joint: rest.offsets[child] + vector for joint, vector in below.items()}
    return found


def _side_frame(bones: Array, images: Array, guess: Array, middle: bool) -> Array:
    """The reflection that takes bones (k, 3) to their images (k, 3): a plain one where it will do, else the best.

    guess: of the parent. middle: whether the joint is its own partner, so that twice must be no change.
    """
    for candidate in _candidates(guess, middle):
        if (np.einsum("ki,ij,kj->k", images, candidate, bones) > _ALIKE).all():
            return candidate
    if middle:
        moment = bones.T @ images
        normal = np.linalg.eigh(guess)[1][:, 0]
        return _reflection(np.linalg.eigh(moment + moment.T - _PRIOR * np.outer(normal, normal))[1][:, 0])
    left, _, right = np.linalg.svd(images.T @ bones + _PRIOR * guess)
    sign = -np.sign(np.linalg.det(left) * np.linalg.det(right))
    best: Array = left @ np.diag([1.0, 1.0, sign]) @ right
    return best


def _candidates(guess: Array, middle: bool) -> Iterator[Array]:
    yield guess
    if not middle:
        # How rigs are built whose two sides turn alike.
        yield -np.eye(3)
    for axis in np.eye(3):
        yield _reflection(axis)


def _reflection(normal: Array) -> Array:
    """The matrix (3, 3) of the mirror across a unit normal."""
    mirror: Array = np.eye(3) - 2 * np.outer(normal, normal)
    return mirror
