"""glTF, USD and OpenSim's tables on the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.test_cli import Mcml, mcml  # noqa: F401
from tests.formats.scenes.reading import read_glb
from tests.motion.bodies.made import person


@pytest.mark.parametrize("format", ["glb", "usd", "usda", "mot", "sto"])
def test_documents_and_files(mcml: Mcml, tmp_path: Path, format: str) -> None:  # noqa: F811
    (tmp_path / "goes.bvh").write_bytes(person(3, 20))
    uuid = json.loads(mcml("import", "goes.bvh", "--json")[1])["documents"][0]["id"]
    code, output, errors = mcml("export", uuid, "--format", format)
    assert code == 0, errors
    assert "up axis" in output + errors
    assert mcml("convert", "goes.bvh", f"alone.{format}")[0] == 0
    exported, converted = ((tmp_path / f"{name}.{format}").read_bytes() for name in ("goes", "alone"))
    if format != "usd":
        assert exported == converted
    if format == "glb":
        assert read_glb(exported).positions().shape == (20, 21, 3)


def test_a_folder_of_documents(mcml: Mcml, tmp_path: Path) -> None:  # noqa: F811
    for number in range(3):
        (tmp_path / f"goes{number}.bvh").write_bytes(person(number, 5))
    assert mcml("import", *(f"goes{number}.bvh" for number in range(3)), "--project", "gait")[0] == 0
    (tmp_path / "out").mkdir()
    assert mcml("export", "--project", "gait", "--format", "glb", "-o", "out")[0] == 0
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [f"goes{number}.glb" for number in range(3)]


def test_usd_without_its_library_says_what_to_install(
    mcml: Mcml,  # noqa: F811
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pxr", None)
    (tmp_path / "goes.bvh").write_bytes(person(3, 5))
    code, output, errors = mcml("convert", "goes.bvh", "goes.usd")
    assert code != 0
    assert "mcml-repository[usd]" in " ".join((output + errors).split())
