"""The part of the add-on that knows nothing of Blender, in this Python."""

from __future__ import annotations

import importlib.util
import itertools
import json
import math
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

ADDON = Path(__file__).resolve().parents[2] / "integrations" / "blender" / "mcml_repository.py"
ORDERS = ["".join(order) for order in itertools.permutations("XYZ")]
NAN = math.nan


@pytest.fixture(scope="module")
def addon() -> ModuleType:
    """The file with nothing but names in the place of Blender."""
    bpy, mathutils = ModuleType("bpy"), ModuleType("mathutils")
    props = ModuleType("bpy.props")
    for name in ("Collection", "Enum", "Int", "Pointer", "String"):
        setattr(props, f"{name}Property", lambda **_: None)
    bpy.types = SimpleNamespace(  # type: ignore[attr-defined]
        **dict.fromkeys(("Operator", "PropertyGroup", "UIList", "AddonPreferences", "Panel"), object)
    )
    mathutils.Vector = tuple  # type: ignore[attr-defined]
    with pytest.MonkeyPatch.context() as patch:
        for module in (bpy, props, mathutils):
            patch.setitem(sys.modules, module.__name__, module)
        spec = importlib.util.spec_from_file_location("mcml_repository", ADDON)
        assert spec is not None
        assert spec.loader is not None
        loaded = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(loaded)
    return loaded


def skeleton(**more: Any) -> dict[str, Any]:
    """A root that moves and turns, and a bone that turns about two axes and rises."""
    root = {"name": "Root", "parent": -1, "offset": [0.0, 90.0, 0.0], "translation": "absolute", "convention": "listed"}
    arm = {"name": "left.arm", "parent": 0, "offset": [0.0, 20.0, 0.0], "translation": "relative"}
    bones = [{**root, "rotation_order": "ZXY"}, {**arm, "convention": "listed", "rotation_order": "ZX"}]
    columns = [f"Root.{channel}" for channel in ("Tx", "Ty", "Tz", "Rz", "Rx", "Ry")]
    columns += [f"left.arm.{channel}" for channel in ("Ty", "Rz", "Rx")]
    return {"bones": bones, "columns": columns, "radians": math.pi / 180, "tips": [], **more}


@pytest.mark.parametrize("order", ORDERS)
def test_matrices_are_those_of_the_product(addon: ModuleType, order: str) -> None:
    rng = np.random.default_rng(1)
    for angles in rng.uniform(-4, 4, (20, 3)):
        listed = order[::-1]
        wanted = Rotation.from_euler(listed, [angles["XYZ".index(axis)] for axis in listed]).as_matrix()
        np.testing.assert_allclose(addon.matrix_of_angles(angles, order), wanted, atol=1e-12)
    for quaternion in rng.normal(0, 2, (20, 4)):
        x, y, z, w = Rotation.from_quat(quaternion).as_quat()
        wanted = Rotation.from_quat(quaternion).as_matrix()
        np.testing.assert_allclose(addon.matrix_of_quaternion((3 * w, 3 * x, 3 * y, 3 * z)), wanted, atol=1e-12)


@pytest.mark.parametrize("order", ORDERS)
def test_angles_are_those_nearest(addon: ModuleType, order: str) -> None:
    rng = np.random.default_rng(2)
    middle = "XYZ".index(order[1])
    for angles in rng.uniform(-9, 9, (200, 3)):
        matrix = addon.matrix_of_angles(angles, order)
        if abs(math.cos(angles[middle])) < 1e-3:
            continue
        near = angles + rng.uniform(-0.2, 0.2, 3)
        found = addon.angles_of_matrix(matrix, order, near)
        np.testing.assert_allclose(addon.matrix_of_angles(found, order), matrix, atol=1e-9)
        # Where the middle angle is far from its ends, the ones nearest are those that it was made of.
        if abs(math.cos(angles[middle])) > 0.5:
            np.testing.assert_allclose(found, angles, atol=1e-6)
        assert addon.angles_of_matrix(matrix, order, list(angles)) == list(angles)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("sign", [1, -1])
def test_a_locked_middle_angle_keeps_the_last(addon: ModuleType, order: str, sign: int) -> None:
    angles = [0.4, 0.4, 0.4]
    angles["XYZ".index(order[1])] = sign * math.pi / 2
    matrix = addon.matrix_of_angles(angles, order)
    near = [angle + 0.3 for angle in angles]
    found = addon.angles_of_matrix(matrix, order, near)
    np.testing.assert_allclose(addon.matrix_of_angles(found, order), matrix, atol=1e-7)
    first = "XYZ".index(order[0])
    assert found[first] == near[first]


def test_curves_are_channels(addon: ModuleType) -> None:
    curves = addon.curves_of(skeleton())
    assert [(curve.bone, curve.path, curve.axis) for curve in curves] == [
        *((0, "location", axis) for axis in range(3)),
        *((0, "rotation_euler", axis) for axis in (2, 0, 1)),
        (1, "location", 1),
        (1, "rotation_euler", 2),
        (1, "rotation_euler", 0),
    ]
    assert [curve.rest for curve in curves] == [0, 90, 0, 0, 0, 0, 0, 0, 0]
    assert addon.held(curves[1], [NAN, 95.5, NAN, 91.0]) == [0, 5.5, 5.5, 1]
    assert [addon.order_of(bone) for bone in skeleton()["bones"]] == ["YXZ", "YXZ"]
    assert addon.editable(skeleton())
    assert not addon.editable({"bones": [{"convention": "listed"}, {"convention": "fixed"}]})


def test_only_what_changed_is_sent(addon: ModuleType) -> None:
    model = skeleton()
    rng = np.random.default_rng(3)
    base = np.round(rng.normal(0, 60, (9, len(model["columns"]))), 4)
    base[4, 7] = NAN
    flat = base.ravel().tolist()
    curves = addon.curves_of(model)
    kept = {curve: [addon.single(v) for v in addon.held(curve, flat[curve.column :: 9])] for curve in curves}
    assert addon.changes_of(model, 11, flat, kept) == (None, 0, 0)
    kept[curves[1]][3] = addon.single(12.5 - 90)
    kept[curves[7]][5] = addon.single(math.radians(45.25))
    kept[curves[7]][4] = 1.0
    block, count, lacking = addon.changes_of(model, 11, flat, kept)
    assert block == {
        "first": 14,
        "columns": ["Root.Ty", "left.arm.Rz"],
        "values": [[12.5, None], [None, None], [None, 45.25]],
    }
    assert (count, lacking) == (2, 1)


def test_numbers_are_the_shortest_that_blender_keeps(addon: ModuleType) -> None:
    curve = addon.curves_of(skeleton())[3]
    for text in ("0.1", "-179.9999", "45", "1234.567"):
        value = addon.single(math.radians(float(text)))
        assert addon.shortest(curve, value) == pytest.approx(float(text), rel=1e-7)
        assert addon.single(math.radians(addon.shortest(curve, value))) == value
    assert addon.shortest(curve, addon.single(math.radians(45.25))) == 45.25


def test_poses_of_other_conventions_are_local(addon: ModuleType) -> None:
    rng = np.random.default_rng(4)
    model = skeleton()
    offsets = np.array([bone["offset"] for bone in model["bones"]])
    local = Rotation.random(2, random_state=rng)
    moved = rng.normal(0, 3, (2, 3))
    positions = [offsets[0] + moved[0]]
    positions.append(positions[0] + local[0].apply(offsets[1] + moved[1]))
    rotations = [local[0].as_quat(), (local[0] * local[1]).as_quat()]
    found = addon.poses_of(model, np.ravel(positions).tolist() * 2, [*np.ravel(rotations), *-np.ravel(rotations)])
    for (locations, turns), move, turn in zip(found, moved, local, strict=True):
        np.testing.assert_allclose(locations, [move, move], atol=1e-12)
        w, x, y, z = turns[0]
        assert (turn.inv() * Rotation.from_quat([x, y, z, w])).magnitude() < 1e-12
        np.testing.assert_allclose(turns[0], turns[1], atol=1e-12)


def test_bones_lead_somewhere(addon: ModuleType) -> None:
    model = skeleton(tips=[{"bone": 1, "offset": [1.0, 2.0, 3.0]}])
    assert addon.ends_of(model) == [(0.0, 20.0, 0.0), (1.0, 2.0, 3.0)]
    assert addon.ends_of(skeleton()) == [(0.0, 20.0, 0.0), (0.0, 2.0, 0.0)]


def test_problems_are_words(addon: ModuleType) -> None:
    said = {"title": "Conflict", "detail": "It is at revision 4.", "remedy": "Read it again."}
    told = addon.problem(412, json.dumps(said).encode())
    assert told == f"It is at revision 4. Read it again. {addon.AGAIN}"
    assert addon.problem(422, b'{"title": "Odd"}') == "Odd"
    assert addon.problem(401, b"{}") == (
        "The server answered with status 401. Set the token in the preferences of this add-on."
    )
    assert addon.problem(502, b"<html>") == addon.problem(502, b"[]") == "The server answered with status 502."


@contextmanager
def answering(status: int, content: bytes, **headers: str) -> Iterator[tuple[str, list[str]]]:
    """The address of a server that always says the same, and the paths that it is asked."""
    asked: list[str] = []

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked.append(self.path)
            self.send_response(status)
            for name, value in headers.items():
                self.send_header(name, value)
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, *_: Any) -> None:
            pass

    with HTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}", asked
        server.shutdown()


def test_a_token_does_not_follow_a_redirect(addon: ModuleType) -> None:
    with (
        answering(200, b"{}") as (other, taken),
        answering(302, b"", Location=other) as (address, asked),
        pytest.raises(addon.RepositoryError, match="status 302"),
    ):
        addon.Server(address, "secret").get("documents", q="a b", cursor="")
    assert (asked, taken) == (["/api/v1/documents?q=a+b"], [])


def test_another_server_is_told(addon: ModuleType) -> None:
    with answering(200, b"<html>") as (address, _), pytest.raises(addon.RepositoryError, match="no MCML repository"):
        addon.Server(f" {address}/ ").get("documents")
    cut = answering(200, b"{", **{"Content-Length": "9"})
    with cut as (address, _), pytest.raises(addon.RepositoryError, match="No answer from"):
        addon.Server(address).get("documents")
    for wrong in ("", "file:///etc/passwd", "localhost:8000"):
        with pytest.raises(addon.RepositoryError, match="must begin with"):
            addon.Server(wrong)
