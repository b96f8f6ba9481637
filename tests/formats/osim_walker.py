"""A small model of OpenSim that walks: pelvis, thighs, shanks and feet with markers, scaled from a generic one.

Axes of OpenSim: x forward, y up, z to the right; metres. Names of joints and signs of angles are those of gait2392: a
bent knee is negative.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import opensim

from mcml.motion.skeleton import Array
from tests.c3d_writer import c3d_bytes, texts

WIDTH, DEPTH = 0.24, 0.15
"""Metres between the ASIS, and from their middle to that of the PSIS."""

SIDES = {"l": -1.0, "r": 1.0}
"""The sign of z."""

MARKERS = {
    "LKNE": ("femur", (0.0, -0.4, 0.05)), "LKNM": ("femur", (0.0, -0.4, -0.05)),
    "LTHI": ("femur", (0.06, -0.2, 0.06)), "LGTR": ("femur", (-0.02, -0.03, 0.08)),
    "LANK": ("tibia", (0.0, -0.38, 0.04)), "LMED": ("tibia", (0.0, -0.38, -0.04)),
    "LTIB": ("tibia", (0.05, -0.15, 0.03)), "LHEE": ("foot", (-0.06, -0.05, 0.0)),
    "LTOE": ("foot", (0.15, -0.05, 0.01)), "LSMH": ("foot", (0.11, -0.04, -0.04)),
}  # fmt: skip
"""Of the left leg: body and place, with z to the side."""

SCALES = {"pelvis": 1.1, "femur": 1.15, "tibia": 0.93, "foot": 1.05}
"""Of the subject, in the sizes of the generic model."""

_GROWN = SCALES["pelvis"]
HIP = (-0.24 * DEPTH - 0.0099 / _GROWN, -0.30 * WIDTH - 0.0109 / _GROWN, 0.33 * WIDTH + 0.0073 / _GROWN)
"""Forward, up and aside of a hip from the middle of the ASIS, so that the subject's is by Harrington et al. 2007."""

PAIRS = {
    "pelvis": ("LASI", "RASI"),
    "femur": ("{}GTR", "{}KNE"),
    "tibia": ("{}TIB", "{}ANK"),
    "foot": ("{}HEE", "{}TOE"),
}
"""Markers whose distance scales a body."""


def make_model(path: Path, scales: Mapping[str, float]) -> opensim.Model:
    """Write a model with bodies of these sizes."""
    model = opensim.Model()
    pelvis = _add_body(model, "pelvis")
    model.addJoint(opensim.FreeJoint("ground_pelvis", model.getGround(), pelvis))
    size = scales["pelvis"]
    for name, place in {"ASI": (0.0, 0.0, WIDTH / 2), "PSI": (-DEPTH, 0.0, 0.045)}.items():
        for side, sign in SIDES.items():
            _add_marker(model, side.upper() + name, pelvis, size * np.array(place) * (1, 1, sign))
    _add_weld(model, "back", pelvis, size * np.array([-0.08, 0.05, 0.0]))
    for side, sign in SIDES.items():
        femur, tibia, foot = (_add_body(model, f"{name}_{side}") for name in ("femur", "tibia", "foot"))
        hip = size * np.array(HIP) * (1, 1, sign)
        turns = {"hip_flexion": (0, 0, 1), "hip_adduction": (sign, 0, 0), "hip_rotation": (0, sign, 0)}
        _add_joint(model, side, "hip", pelvis, hip, femur, turns)
        knee, ankle = scales["femur"] * np.array([0, -0.4, 0]), scales["tibia"] * np.array([0, -0.38, 0])
        _add_joint(model, side, "knee", femur, knee, tibia, {"knee_angle": (0, 0, 1)})
        _add_joint(model, side, "ankle", tibia, ankle, foot, {"ankle_angle": (0, 0, 1)})
        _add_weld(model, f"mtp_{side}", foot, scales["foot"] * np.array([0.13, -0.05, 0]))
        bodies = {"femur": femur, "tibia": tibia, "foot": foot}
        for name, (body, place) in MARKERS.items():
            _add_marker(model, side.upper() + name[1:], bodies[body], scales[body] * np.array(place) * (1, 1, sign))
    model.finalizeConnections()
    model.printToXML(str(path))
    return model


def _add_body(model: opensim.Model, name: str) -> opensim.Body:
    body = opensim.Body(name, 1.0, opensim.Vec3(0), opensim.Inertia(1, 1, 1))
    model.addBody(body)
    return body


def _add_weld(model: opensim.Model, name: str, parent: opensim.Body, place: Array) -> None:
    """Add a joint that does not turn, with a body behind it."""
    zero, child = opensim.Vec3(0), _add_body(model, f"behind_{name}")
    model.addJoint(opensim.WeldJoint(name, parent, opensim.Vec3(*place.tolist()), zero, child, zero, zero))


def _add_marker(model: opensim.Model, name: str, body: opensim.Body, place: Array) -> None:
    model.addMarker(opensim.Marker(name, body, opensim.Vec3(*place.tolist())))


def _add_joint(
    model: opensim.Model,
    side: str,
    name: str,
    parent: opensim.Body,
    place: Array,
    child: opensim.Body,
    turns: Mapping[str, tuple[float, float, float]],
) -> None:
    """turns: the axis of each angle, in the order of rotation."""
    transform = opensim.SpatialTransform()
    # Axes without an angle must not be parallel to those with one.
    transform.updTransformAxis(1).setAxis(opensim.Vec3(1, 0, 0))
    transform.updTransformAxis(2).setAxis(opensim.Vec3(0, 1, 0))
    for number, (angle, direction) in enumerate(turns.items()):
        axis = transform.updTransformAxis(number)
        axis.setCoordinateNames(opensim.ArrayStr(f"{angle}_{side}", 1))
        axis.setAxis(opensim.Vec3(*direction))
        axis.set_function(opensim.LinearFunction(1.0, 0.0))
    zero = opensim.Vec3(0)
    joint = opensim.CustomJoint(
        f"{name}_{side}", parent, opensim.Vec3(*place.tolist()), zero, child, zero, zero, transform
    )
    model.addJoint(joint)


def record(model: opensim.Model, degrees: Mapping[str, Array], places: Array, rate: float) -> bytes:
    """A C3D file, in millimetres with z up, of the markers while the joints have these angles.

    places: (n, 3) metres of the pelvis.
    """
    state = model.initSystem()
    names = [marker.getName() for marker in model.getMarkerSet()]
    points = np.empty((len(places), len(names), 3))
    for frame, place in enumerate(places):
        for axis in range(3):
            model.updCoordinateSet().get(f"ground_pelvis_coord_{3 + axis}").setValue(state, float(place[axis]), False)
        for name, course in degrees.items():
            model.updCoordinateSet().get(name).setValue(state, float(np.radians(course[frame])), False)
        model.realizePosition(state)
        for index, name in enumerate(names):
            x, y, z = model.getMarkerSet().get(name).getLocationInGround(state).to_numpy()
            points[frame, index] = 1000 * x, -1000 * z, 1000 * y
    up = {"POINT:Y_SCREEN": texts("+Z")}
    return c3d_bytes(points.astype(np.float32), labels=names, rate=rate, parameters=up)


JOINTS = ["back", *(f"{name}_{side}" for name in ("hip", "knee", "ankle", "mtp") for side in SIDES)]
BONES = ["pelvis", *(f"{name}_{side}" for name in ("femur", "tibia") for side in SIDES)]
_TO_LAB = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
"""Of vectors with y up, to z up and y left."""


def trace_skeleton(path: Path, model: Path, solved: Mapping[str, Array]) -> None:
    """Write joints and bones of a motion, and at rest, as `Sample` reads them. solved: degrees, or metres, by name."""
    read = opensim.Model(str(model))
    state = read.initSystem()
    frames = len(next(iter(solved.values())))
    positions, rotations = np.empty((frames + 1, len(JOINTS), 3)), np.empty((frames + 1, len(BONES), 3, 3))
    coordinates = {item.getName(): item for item in read.getCoordinateSet()}
    turns = {name for name, item in coordinates.items() if item.getMotionType() == opensim.Coordinate.Rotational}
    for frame in range(frames + 1):
        for name, item in coordinates.items():
            value = 0.0 if frame == frames else float(solved[name][frame])
            if not item.getDefaultLocked():
                item.setValue(state, np.radians(value) if name in turns else value, False)
        read.realizePosition(state)
        for place, name in enumerate(JOINTS):
            frame_of_joint = read.getJointSet().get(name).getChildFrame()
            positions[frame, place] = _TO_LAB @ frame_of_joint.getPositionInGround(state).to_numpy()
        for place, name in enumerate(BONES):
            axes = read.getBodySet().get(name).getRotationInGround(state)
            rotations[frame, place] = _TO_LAB @ [[axes.get(row, column) for column in range(3)] for row in range(3)]
    # The bones' axes at rest, turned so that y is left and z up.
    arrays = {"positions": positions[:-1], "rotations": rotations[:-1] @ _TO_LAB.T}
    rest = {"rest_positions": positions[-1], "rest_rotations": rotations[-1] @ _TO_LAB.T}
    degrees = {f"deg_{name}": values for name, values in solved.items()}
    np.savez(path, joints=np.array(JOINTS), bones=np.array(BONES), **arrays, **rest, **degrees)  # type: ignore[arg-type]


def scale_model(folder: Path, model: str, static: str) -> Path:
    """Scale a model of a folder to the distances of markers in a standing trial (TRC), by OpenSim's own tool."""
    measurements = ""
    for body, pair in PAIRS.items():
        for side in [""] if body == "pelvis" else SIDES:
            name = f"{body}_{side}" if side else body
            markers = " ".join(marker.format(side.upper()) for marker in pair)
            measurements += (
                f'<Measurement name="{name}"><apply>true</apply><MarkerPairSet><objects><MarkerPair><markers>{markers}'
                "</markers></MarkerPair></objects></MarkerPairSet><BodyScaleSet><objects>"
                f'<BodyScale name="{name}"><axes> X Y Z</axes></BodyScale></objects></BodyScaleSet></Measurement>'
            )
    (folder / "scale.xml").write_text(
        f"""<?xml version="1.0" encoding="UTF-8" ?>
<OpenSimDocument Version="40500"><ScaleTool name="subject"><mass>60</mass>
<GenericModelMaker><model_file>{model}</model_file></GenericModelMaker>
<ModelScaler><apply>true</apply><scaling_order>measurements</scaling_order>
<MeasurementSet><objects>{measurements}</objects></MeasurementSet><marker_file>{static}</marker_file>
<time_range>0 0.5</time_range><output_model_file>scaled.osim</output_model_file></ModelScaler>
<MarkerPlacer><apply>false</apply></MarkerPlacer></ScaleTool></OpenSimDocument>"""
    )
    # It answers false where no markers are to be moved, and writes the model.
    opensim.ScaleTool(str(folder / "scale.xml")).run()
    assert (folder / "scaled.osim").exists()
    return folder / "scaled.osim"


def solve_angles(folder: Path, model: Path, trial: str) -> dict[str, Array]:
    """The degrees of each coordinate in each frame of a trial (TRC), by OpenSim's inverse kinematics."""
    tool = opensim.InverseKinematicsTool()
    tool.set_model_file(str(model))
    tool.setMarkerDataFileName(str(folder / trial))
    times = opensim.TimeSeriesTableVec3(str(folder / trial)).getIndependentColumn()
    tool.setStartTime(times[0])
    tool.setEndTime(times[-1])
    tool.set_accuracy(1e-9)
    tool.set_report_errors(False)
    for marker in opensim.Model(str(model)).getMarkerSet():
        task = opensim.IKMarkerTask()
        task.setName(marker.getName())
        task.setWeight(1.0)
        tool.getIKTaskSet().cloneAndAppend(task)
    tool.setOutputMotionFileName(str(folder / "solved.mot"))
    assert tool.run()
    table = opensim.TimeSeriesTable(str(folder / "solved.mot"))
    assert table.getTableMetaDataAsString("inDegrees") == "yes"
    return {name: table.getDependentColumn(name).to_numpy().copy() for name in table.getColumnLabels()}
