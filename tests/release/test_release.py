"""What is released: wheel and sdist are built, hold what they must, and work where nothing else of the house is.

No network: the backend and all dependencies are those of the environment; only the house itself is built and installed.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from tests.builders import bvh

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = [name for name in ("service", "schemas", "mcml") if (ROOT / name).is_dir()]


def build(source: Path, target: Path) -> dict[str, Path]:
    """Wheel and sdist of a folder, by the ends of their names."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-t", "sdist", "-d", str(target)]
    subprocess.run(command, cwd=source, check=True, capture_output=True)
    return {path.suffix: path for path in target.iterdir()}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return build(ROOT, tmp_path_factory.mktemp("built"))


def names(wheel: Path) -> set[str]:
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


def test_a_wheel_holds_all_of_the_house_and_nothing_else(built: dict[str, Path]) -> None:
    tracked = {
        path.relative_to(ROOT).as_posix()
        for name in PACKAGES
        for path in (ROOT / name).rglob("*")
        if path.suffix in (".py", ".csv", ".txt") and not {"static", "node_modules"} & set(path.parts)
    }
    held = names(built[".whl"])
    assert tracked <= held
    assert "service/_data/mcml.dtd" in held
    assert {
        f"service/_data/migrations/versions/{path.name}" for path in (ROOT / "migrations/versions").glob("*.py")
    } <= held
    folders = {name.partition("/")[0] for name in held}
    assert {name for name in folders if not name.endswith(".dist-info")} == set(PACKAGES)


def test_an_sdist_makes_the_same_wheel_without_git(built: dict[str, Path], tmp_path: Path) -> None:
    with tarfile.open(built[".gz"]) as archive:
        archive.extractall(tmp_path, filter="data")
    (folder,) = tmp_path.iterdir()
    assert (folder / "integrations/blender/mcml_repository.py").is_file()
    again = build(folder, tmp_path / "again")
    assert again[".whl"].name == built[".whl"].name
    assert names(again[".whl"]) == names(built[".whl"])


def test_an_installed_wheel_works(built: dict[str, Path], tmp_path: Path) -> None:
    home = tmp_path / "installed"
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "--no-index"]
    subprocess.run([*pip, "--no-compile", "--target", str(home), str(built[".whl"])], check=True)
    (tmp_path / "walk.bvh").write_bytes(bvh())
    environment = os.environ | {"PYTHONPATH": str(home), "MCML_DATABASE": f"sqlite:///{tmp_path / 'store.db'}"}

    def run(*command: str | Path) -> str:
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    where = "import service, importlib.metadata as m; print(service.__file__, m.version('mcml-repository'))"
    file, version = run(sys.executable, "-P", "-c", where).split()
    assert Path(file).is_relative_to(home)
    assert built[".whl"].name == f"mcml_repository-{version}-py3-none-any.whl"
    # The definition of the language, and the migrations, lie in the wheel.
    run(home / "bin" / "mcml", "convert", "walk.bvh", "walk.mcml")
    assert (tmp_path / "walk.mcml").read_bytes().startswith(b"<?xml")
    run(home / "bin" / "mcml", "db", "upgrade")
    assert (tmp_path / "store.db").stat().st_size


def test_the_changelog_has_a_part_for_each_version() -> None:
    headings = re.findall(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    first, *released = headings
    assert re.fullmatch(r"Unreleased|\d+\.\d+\.\d+", first)
    assert all(re.fullmatch(r"\d+\.\d+\.\d+", heading) for heading in released)
    numbers = [tuple(map(int, heading.split("."))) for heading in headings if heading != "Unreleased"]
    assert numbers == sorted(set(numbers), reverse=True)
