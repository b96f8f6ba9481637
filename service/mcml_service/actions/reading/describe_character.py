"""The body with a skin that a document is drawn with, to the measure of its skeleton."""

from __future__ import annotations

import numpy as np

from mcml.errors import ConversionError
from mcml.language.elements import to_head
from mcml.motion.characters.figure import bind_character
from mcml.motion.skin import Character
from mcml.motion.units import reading_of
from mcml_schemas.skeletons import CharacterMesh, CharacterView
from mcml_service.clips.bodies import read_bodies
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

_DIGITS, _WEIGHT_DECIMALS = 5, 4
"""Of coordinates, in parts of the size of the body; decimals of weights."""


def describe_character(tx: Transaction, stored: StoredDocument) -> CharacterView:
    """Describe the body of a document in the reference pose of its calibration, or say why it has none."""
    head = to_head(tx.heads.document(stored), stored.frame_time)
    reading = reading_of(head)
    (listed,) = tx.columns.documents([stored.key])
    try:
        made = bind_character(head.skeleton, reading, read_bodies(tx, [listed])[stored.key].calibration.start)
    except ConversionError as error:
        return CharacterView(reason=error.what, remedy=error.remedy)
    return CharacterView(mesh=describe_mesh(made))


def describe_mesh(made: Character) -> CharacterMesh:
    """Return the mesh as numbers, rounded to a hundred-thousandth of its size."""
    size = float(np.ptp(made.points, axis=0).max())
    decimals = _DIGITS - int(np.floor(np.log10(size)))
    weights = np.round(made.weights, _WEIGHT_DECIMALS)
    weights[:, 0] += 1.0 - weights.sum(axis=1)
    return CharacterMesh(
        points=np.round(made.points, decimals).ravel().tolist(),
        triangles=made.faces.ravel().tolist(),
        joints=made.joints.ravel().tolist(),
        weights=np.round(weights, _WEIGHT_DECIMALS).ravel().tolist(),
        bind_positions=made.places.tolist(),
        bind_rotations=made.turns.tolist(),
        normals=None if made.colours is None else np.round(made.normals, _WEIGHT_DECIMALS).ravel().tolist(),
        colours=None if made.colours is None else made.colours.ravel().tolist(),
    )
