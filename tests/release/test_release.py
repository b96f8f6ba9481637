"""What is released: wheel and sdist are built, hold what they must, and work where nothing else of the house is.

No network: the backend and all dependencies are those of the environment; only the house itself is built and installed.
"""

from __future__ import annotations

import os
import re
import subprocess
import tarfile
import zipfile
from pathlib import Path

import pytest

from tests.builders import bvh
from tests.release.conftest import ROOT, build

PACKAGES = {"mcml": "mcml", "service/mcml_service": "mcml_service", "schemas/mcml_schemas": "mcml_schemas"}
"""Folders of packages, and what a wheel calls them."""


def names(wheel: Path) -> set[str]:
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


def test_a_wheel_holds_all_of_the_house_and_nothing_else(built: dict[str, Path]) -> None:
    tracked = {
        f"{package}/{path.relative_to(ROOT / folder).as_posix()}"
        for folder, package in PACKAGES.items()
        for path in (ROOT / folder).rglob("*")
        if path.suffix in (".py", ".pyi", ".csv", ".txt", ".json") or path.name == "py.typed"
    }
    held = names(built[".whl"])
    assert tracked <= held
    assert {
        "mcml/_data/mcml.dtd",
        "mcml_service/_data/web/pages.json",
        "mcml_service/_data/web/static/index.html",
        "mcml_service/_data/web/static/guide/index.html",
    } < held
    migrations = {path.name for path in (ROOT / "migrations/versions").glob("*.py")}
    assert {f"mcml_service/_data/migrations/versions/{name}" for name in migrations} <= held
    folders = {name.partition("/")[0] for name in held}
    assert {name for name in folders if not name.endswith(".dist-info")} == set(PACKAGES.values())


@pytest.mark.slow
def test_an_sdist_makes_the_same_wheel_without_git(built: dict[str, Path], tmp_path: Path) -> None:
    with tarfile.open(built[".gz"]) as archive:
        archive.extractall(tmp_path, filter="data")
    (folder,) = tmp_path.iterdir()
    assert (folder / "integrations/blender/mcml_repository.py").is_file()
    again = build(folder, tmp_path / "again")
    assert again[".whl"].name == built[".whl"].name
    assert names(again[".whl"]) == names(built[".whl"])


@pytest.mark.slow
def test_an_installed_wheel_works(built: dict[str, Path], installed: Path, tmp_path: Path) -> None:
    (tmp_path / "walk.bvh").write_bytes(bvh())
    environment = os.environ | {"MCML_DATABASE": f"sqlite:///{tmp_path / 'store.db'}"}

    def run(*command: str | Path) -> str:
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    where = "import mcml_service as s, importlib.metadata as m; print(s.__file__, m.version('mcml-repository'))"
    file, version = run(installed / "python", "-P", "-c", where).split()
    assert Path(file).is_relative_to(installed.parent)
    assert built[".whl"].name == f"mcml_repository-{version}-py3-none-any.whl"
    # The definition of the language, and the migrations, lie in the wheel.
    run(installed / "mcml", "convert", "walk.bvh", "walk.mcml")
    assert (tmp_path / "walk.mcml").read_bytes().startswith(b"<?xml")
    run(installed / "mcml", "db", "upgrade")
    assert (tmp_path / "store.db").stat().st_size


def test_the_changelog_has_a_part_for_each_version() -> None:
    headings = re.findall(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    first, *released = headings
    assert re.fullmatch(r"Unreleased|\d+\.\d+\.\d+", first)
    parts = [re.fullmatch(r"(\d+)\.(\d+)\.(\d+) \((\d{4}-\d\d-\d\d)\): \w.*", heading) for heading in released]
    numbers = [tuple(map(int, part.groups()[:3])) for part in parts if part]
    assert len(numbers) == len(released)
    assert numbers == sorted(set(numbers), reverse=True)
    dates = [part[4] for part in parts if part]
    assert dates == sorted(dates, reverse=True)
    told = re.findall(r"^## (\d+\.\d+\.\d+),", (ROOT / "docs/releases.md").read_text(), re.MULTILINE)
    assert told == [".".join(map(str, number)) for number in numbers]


def test_entries_of_the_changelog_are_short_and_sorted_by_kind() -> None:
    kinds = ["Breaking", "Added", "Changed", "Fixed", "Security"]
    for version in (ROOT / "CHANGELOG.md").read_text().split("\n## ")[1:]:
        headings = re.findall(r"^### (.*)$", version, re.MULTILINE)
        assert headings == [kind for kind in kinds if kind in headings]
        for line in version.splitlines()[1:]:
            assert not line or line.startswith(("### ", "- ")), line
            assert len(line) <= 160, line
            assert not line.startswith("- ") or "](docs/" in line, line
