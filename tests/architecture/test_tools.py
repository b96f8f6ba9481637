"""The commands to learn: what is checked before a commit, and other versions of Python beside the usual one."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]


def made(*arguments: str, folder: Path = ROOT) -> list[str]:
    """The lines that make would run."""
    command = ["make", "--dry-run", "--file", str(ROOT / "Makefile"), *arguments]
    return subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout.splitlines()


def test_hooks_run_what_make_check_runs() -> None:
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"][0]["hooks"]
    # All but what installs the environment, and the audit, which asks the network.
    apart = (".venv/bin/python -m pip", ".venv/bin/python -m tests.release.audit")
    checks = [line for line in made("check") if line.startswith(".venv/bin/") and not line.startswith(apart)]
    assert [hook["entry"] for hook in hooks] == checks
    assert {hook["language"] for hook in hooks} == {"system"}


@pytest.fixture
def other_python(tmp_path: Path) -> Path:
    """A program that says it is Python 3.99."""
    path = tmp_path / "python3.99"
    path.write_text("#!/bin/sh\necho 3.99\n")
    path.chmod(0o755)
    return path


@pytest.mark.parametrize(("there", "used"), [("3.11", ".venv-3.99"), ("3.99", ".venv"), (None, ".venv")])
def test_another_python_has_an_environment_of_its_own(
    tmp_path: Path, other_python: Path, there: str | None, used: str
) -> None:
    for name in ("pyproject.toml", "requirements-dev.lock"):
        (tmp_path / name).touch()
    if there is not None:
        (tmp_path / f".venv/lib/python{there}").mkdir(parents=True)
    lines = made("test", f"PYTHON={other_python}", folder=tmp_path)
    assert f"{other_python} -m venv {used}" in lines
    assert any(line.startswith(f"{used}/bin/python -m pytest ") for line in lines)
