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


def told(result: tuple[int, str, str]) -> str:
    assert result[0] != 0
    return " ".join((result[1] + result[2]).split())


def test_asf_and_amc_are_written_side_by_side(mcml: Mcml, tmp_path: Path) -> None:  # noqa: F811
    uuid = json.loads(mcml("import", "leg.asf", "leg.amc", "--json")[1])["documents"][0]["id"]
    assert mcml("export", uuid, "--format", "asf-amc", "--output", "out.amc")[0] == 0
    assert (tmp_path / "out.asf").read_bytes() == (tmp_path / "leg.asf").read_bytes()
    assert (tmp_path / "out.amc").read_bytes() == (tmp_path / "leg.amc").read_bytes()
    assert mcml("export", uuid, "--format", "asf-amc", "--output", "both.zip")[0] == 0
    assert (tmp_path / "both.zip").read_bytes()[:2] == b"PK"
    for name in ("out.bvh", "out", "out.txt"):
        assert ".zip" in told(mcml("export", uuid, "--format", "asf-amc", "--output", name))
        assert not (tmp_path / name).exists()


@pytest.mark.parametrize(
    ("format", "name", "wanted"),
    [("usd", "x.usda", ".usdc"), ("usda", "x.usd", ".usda"), ("bvh", "x.mcml", ".bvh"), ("asf", "x.amc", ".asf")],
)
def test_a_name_of_another_format_is_refused(
    mcml: Mcml,  # noqa: F811
    tmp_path: Path,
    format: str,
    name: str,
    wanted: str,
) -> None:
    uuid = json.loads(mcml("import", "walk.bvh", "--json")[1])["documents"][0]["id"]
    assert wanted in told(mcml("export", uuid, "--format", format, "--output", name))
    assert wanted in told(mcml("convert", "walk.bvh", name, "--to", format))
    assert not (tmp_path / name).exists()


@pytest.mark.parametrize("format", ["bvh", "c3d", "trc", "glb", "usd"])
def test_no_format_guesses_a_frame_rate(mcml: Mcml, tmp_path: Path, format: str) -> None:  # noqa: F811
    uuid = json.loads(mcml("import", "leg.asf", "leg.amc", "--unit", "cm", "--json")[1])["documents"][0]["id"]
    assert "frame_time" in told(mcml("export", uuid, "--format", format, "-o", f"x.{format}"))
    assert mcml("export", uuid, "--format", format, "-o", f"x.{format}", "--frame-time", "0.02")[0] == 0
    assert (tmp_path / f"x.{format}").stat().st_size
    timed = json.loads(mcml("import", "walk.bvh", "--unit", "cm", "--json")[1])["documents"][0]["id"]
    assert "states its frame time" in told(mcml("export", timed, "--format", format, "--frame-time", "7", "-o", "y"))


def test_a_program_decides_format_and_ending(mcml: Mcml, tmp_path: Path) -> None:  # noqa: F811
    (tmp_path / "goes.bvh").write_bytes(person(3, 20))
    uuid = json.loads(mcml("import", "goes.bvh", "--json")[1])["documents"][0]["id"]
    code, output, errors = mcml("convert", "goes.bvh", "made", "--for", "blender")
    assert code == 0, errors
    assert "for Blender: BVH, lengths in m, Y up" in " ".join((output + errors).split())
    assert mcml("export", uuid, "--for", "blender", "-o", "made.bvh", "--force")[0] == 0
    assert (tmp_path / "made.bvh").read_bytes().startswith(b"HIERARCHY")
    assert mcml("export", uuid, "--for", "unity")[0] == 0
    assert (tmp_path / "goes.glb").read_bytes().startswith(b"glTF")
    assert "Use one of: blender" in told(mcml("export", uuid, "--for", "lathe"))
