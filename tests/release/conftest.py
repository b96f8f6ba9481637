"""Wheel and sdist of the house, and an environment that has nothing else of it."""

from __future__ import annotations

import site
import subprocess
import sys
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def build(source: Path, target: Path) -> dict[str, Path]:
    """Wheel and sdist of a folder, by the ends of their names."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-t", "sdist", "-d", str(target)]
    subprocess.run(command, cwd=source, check=True, capture_output=True)
    return {path.suffix: path for path in target.iterdir()}


@pytest.fixture(scope="package")
def built(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return build(ROOT, tmp_path_factory.mktemp("built"))


@pytest.fixture(scope="package")
def installed(built: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The programs of an environment with the wheel, and with the packages of this one but for the house itself."""
    home = tmp_path_factory.mktemp("installed")
    venv.create(home, with_pip=False)
    (packages,) = home.glob("lib/python*/site-packages")
    pip = [sys.executable, "-m", "pip", "--python", str(home / "bin/python"), "install", "--quiet", "--no-compile"]
    # Of the folder of packages that is named here no .pth file is read, so the checkout is not found.
    subprocess.run([*pip, "--disable-pip-version-check", "--no-deps", "--no-index", str(built[".whl"])], check=True)
    (packages / "others.pth").write_text("\n".join(site.getsitepackages()))
    return home / "bin"
