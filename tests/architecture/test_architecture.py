"""The house: layers, sizes, names, one migration that makes what the tables say."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext

from service.storage.database import Database
from service.storage.schema import metadata

ROOT = Path(__file__).resolve().parents[2]
LINES = 400
ATTICS = {"utils", "helpers", "common", "manager", "misc"}


def sources() -> list[Path]:
    folders = ("service", "schemas", "mcml", "benchmarks", "tests")
    return [path for folder in folders for path in (ROOT / folder).rglob("*.py") if "static" not in path.parts]


def test_layers() -> None:
    command = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run([command], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


PLANTS = {
    "service/storage/rows.py": ("service.settings", "service.actions.editing.edit_names"),
    "service/motion/clip.py": ("sqlalchemy", "service.formats"),
    "service/formats/bvh.py": ("service.mcml.element", "pydantic"),
    "service/analysis/dance/bars.py": ("pydantic", "service.analysis.reach_blending.fit", "fastapi"),
    "service/mcml/element.py": ("schemas.problem", "service.storage.rows"),
    "service/jobs/worker.py": ("fastapi", "service.api.problems"),
    "service/actions/reading/read_clip.py": ("service.actions.editing.edit_names",),
    "service/actions/labelling/edit_labels.py": ("service.actions.exporting.export_motion",),
    "schemas/problem.py": ("service.errors",),
    "service/operations/call.py": ("fastapi", "service.api.policy", "mcml"),
    "mcml/client.py": ("service.cli.shared", "service.app"),
}
"""Imports that no module may have: each kind of what the contracts forbid."""


def _linted(tmp_path: Path, plants: dict[str, tuple[str, ...]]) -> str:
    """What import-linter says of the sources with these imports added."""
    for name in ("service", "schemas", "mcml"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__", "static"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for name, modules in plants.items():
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        before = path.read_text() if path.exists() else ""
        path.write_text(before + "".join(f"\nimport {module}\n" for module in modules))
    command = Path(sys.executable).with_name("lint-imports")
    return subprocess.run([command, "--no-cache"], cwd=tmp_path, capture_output=True, text=True).stdout


def test_planted_imports_are_found(tmp_path: Path) -> None:
    said = " ".join(_linted(tmp_path, PLANTS).split())
    for name, modules in PLANTS.items():
        planted_in = name.removesuffix(".py").replace("/", ".")
        for module in modules:
            assert f"{planted_in} -> {module}" in said, (planted_in, module)


@pytest.mark.parametrize("name", ["service/attic/__init__.py", "service/actions/attic/__init__.py"])
def test_a_package_without_a_place_is_found(tmp_path: Path, name: str) -> None:
    assert "attic" in _linted(tmp_path, {name: ()})


def test_files_stay_readable() -> None:
    long = {str(path.relative_to(ROOT)): lines for path in sources() if (lines := path.read_text().count("\n")) > LINES}
    assert not long, "split these at their second reason to change"


def test_no_attics() -> None:
    assert not [path for path in sources() if path.stem in ATTICS]


def test_migrations_make_what_the_tables_say(database: Database) -> None:
    with database.dialect.reading() as connection:
        differences = compare_metadata(MigrationContext.configure(connection), metadata)
    assert differences == []


def test_only_storage_and_the_query_plan_speak_sql() -> None:
    allowed = ("service/storage/", "service/xpath/plan.py", "service/actions/keeping/keep_store.py")
    for path in (ROOT / "service").rglob("*.py"):
        name = path.relative_to(ROOT).as_posix()
        if not name.startswith(allowed):
            assert "import sqlalchemy" not in path.read_text(), name
            assert "from sqlalchemy" not in path.read_text(), name
