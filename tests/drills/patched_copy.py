"""A copy of the program with a small patch, and which files the patch touched."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
COPIED = ("mcml", "service", "schemas", "migrations", "docs", "tests")
FILES = ("mcml.dtd", "pyproject.toml", "README.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md", "Makefile")
LEFT_OUT = shutil.ignore_patterns("__pycache__", "node_modules", "static", "src", "*.bvh", "*.c3d")


class PatchedCopy:
    """The packages, their documentation and their tests in a folder of their own. touched: files that were patched."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.touched: set[str] = set()
        for name in COPIED:
            shutil.copytree(ROOT / name, folder / name, ignore=LEFT_OUT)
        for name in FILES:
            shutil.copy(ROOT / name, folder)

    def add(self, name: str, text: str) -> None:
        """A new file."""
        path = self.folder / name
        assert not path.exists(), f"{name} is there already"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
        self.touched.add(name)

    def put(self, name: str, before: str, text: str) -> None:
        """A text before the only place where another one stands in a file."""
        path = self.folder / name
        content = path.read_text(encoding="utf-8")
        assert content.count(before) == 1, f"{name} has {content.count(before)} of {before!r}"
        path.write_text(content.replace(before, text + before), encoding="utf-8")
        self.touched.add(name)

    def run(self, *arguments: str) -> str:
        """What Python prints that knows the packages of the copy alone."""
        places = os.pathsep.join(str(self.folder / name) for name in ("", "service", "schemas"))
        environment = {name: value for name, value in os.environ.items() if not name.startswith("MCML_")}
        environment |= {"PYTHONPATH": places, "MCML_LOGIN": "auto"}
        command = [sys.executable, *arguments]
        done = subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, (done.stdout + done.stderr)[-4000:]
        return done.stdout


def count_named_files(what: str) -> int:
    """How many files a row of "Where to add what" names."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    (row,) = re.findall(rf"^\| {re.escape(what)} \|(.*)\|$", text, re.MULTILINE)
    return len({name for name in re.findall(r"`([^`]+)`", row) if "/" in name})
