"""The house: layers, sizes, names, one migration that makes what the tables say."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext

from mcml_service.storage.database import Database
from mcml_service.storage.schema import metadata

ROOT = Path(__file__).resolve().parents[2]
LINES = 400
ATTICS = {"utils", "helpers", "common", "manager", "misc"}


def sources() -> list[Path]:
    """The project's own modules: what is built for the studio, and its packages, are not."""
    folders = ("service", "schemas", "mcml", "benchmarks", "tests")
    found = [path for folder in folders for path in (ROOT / folder).rglob("*.py")]
    return [path for path in found if not {"static", "node_modules"} & set(path.parts)]


def test_layers() -> None:
    command = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run([command], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


PLANTS = {
    "service/mcml_service/storage/rows.py": ("mcml_service.settings", "mcml_service.actions.editing.edit_names"),
    "mcml/motion/clip.py": ("sqlalchemy", "mcml.formats"),
    "mcml/numerics/runs.py": ("mcml.motion.clip", "pydantic"),
    "service/mcml_service/processes/programs.py": ("mcml_service.settings", "mcml_service.xpath.limits"),
    "mcml/formats/bvh.py": ("mcml.language.element", "pydantic"),
    "service/mcml_service/analysis/dance/bars.py": ("pydantic", "mcml_service.analysis.reach_blending.fit", "fastapi"),
    "mcml/language/element.py": ("mcml_schemas.problem", "mcml_service.storage.rows"),
    "service/mcml_service/jobs/worker.py": ("fastapi", "mcml_service.api.problems"),
    "service/mcml_service/actions/reading/read_clip.py": ("mcml_service.actions.editing.edit_names",),
    "service/mcml_service/actions/labelling/edit_labels.py": ("mcml_service.actions.exporting.export_motion",),
    "schemas/mcml_schemas/problem.py": ("mcml.errors",),
    "mcml/files/open_clip.py": ("mcml.client.client", "mcml_service.settings"),
    "service/mcml_service/operations/call.py": ("fastapi", "mcml_service.api.policy", "mcml.client.client"),
    "mcml/client/client.py": ("mcml_service.cli.shared", "fastapi"),
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
    found = os.pathsep.join(str(tmp_path / name) for name in ("", "service", "schemas"))
    environment = os.environ | {"PYTHONPATH": found}
    said = subprocess.run([command, "--no-cache"], cwd=tmp_path, env=environment, capture_output=True, text=True)
    return said.stdout


def test_planted_imports_are_found(tmp_path: Path) -> None:
    said = " ".join(_linted(tmp_path, PLANTS).split())
    for name, modules in PLANTS.items():
        planted_in = name.removesuffix(".py").removeprefix("service/").removeprefix("schemas/").replace("/", ".")
        for module in modules:
            assert f"{planted_in} -> {module}" in said, (planted_in, module)


@pytest.mark.parametrize("name", ["mcml/attic", "service/mcml_service/attic", "service/mcml_service/actions/attic"])
def test_a_package_without_a_place_is_found(tmp_path: Path, name: str) -> None:
    assert "attic" in _linted(tmp_path, {f"{name}/__init__.py": ()})


def test_files_stay_readable() -> None:
    long = {str(path.relative_to(ROOT)): lines for path in sources() if (lines := path.read_text().count("\n")) > LINES}
    assert not long, "split these at their second reason to change"


def test_no_attics() -> None:
    assert not [path for path in sources() if path.stem in ATTICS]


FRAMEWORK_CALLS = {"writable", "handle_request", "WebBuild", "dependencies", "initialize", "send_400_response"}
"""What another library calls: methods, and the hook that hatchling looks for."""
CALLED_FROM_OUTSIDE = {"open_store", "to_pandas"}
"""What an entry point of pyproject.toml names, and what users of the library call."""


def _defined(module: ast.Module) -> Iterator[str]:
    """Functions, classes, methods and constants of a module, but what decorators hand to somebody, and dunders."""
    classes = [node for node in ast.walk(module) if isinstance(node, ast.ClassDef)]
    for body in (module.body, *(node.body for node in classes)):
        for node in body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                if isinstance(node, ast.ClassDef) or all(map(_only_shapes, node.decorator_list)):
                    yield node.name
            elif body is module.body and isinstance(node, ast.Assign | ast.AnnAssign):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                yield from (target.id for target in targets if isinstance(target, ast.Name))


def _only_shapes(decorator: ast.expr) -> bool:
    return ast.unparse(decorator) in ("property", "staticmethod", "classmethod", "cache", "contextmanager")


def _used(module: ast.Module) -> Iterator[str]:
    """Words of a module that may mean a definition: names, attributes, imports, and texts like "module:name"."""
    for node in ast.walk(module):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
            yield node.id
        elif isinstance(node, ast.Attribute):
            yield node.attr
        elif isinstance(node, ast.alias):
            yield node.name.rpartition(".")[2]
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and " " not in node.value:
            yield from re.findall(r"\w+", node.value)


def test_nothing_is_unused() -> None:
    """Nothing is defined for nobody, or for tests alone."""
    folders = [folder for name in ("service", "schemas", "migrations", "mcml") if (folder := ROOT / name).is_dir()]
    modules = {
        path: ast.parse(path.read_text())
        for folder in folders
        for path in folder.rglob("*.py")
        if "node_modules" not in path.parts
    }
    used = {word for module in modules.values() for word in _used(module)} | FRAMEWORK_CALLS | CALLED_FROM_OUTSIDE
    unused = [
        f"{path.relative_to(ROOT)}: {name}"
        for path, module in modules.items()
        if path.relative_to(ROOT).parts[0] != "migrations"
        for name in _defined(module)
        if name not in used and not (name.startswith("__") and name.endswith("__"))
    ]
    assert not unused, "delete these, or move them to the tests"


def test_migrations_make_what_the_tables_say(database: Database) -> None:
    with database.dialect.reading() as connection:
        differences = compare_metadata(MigrationContext.configure(connection), metadata)
    assert differences == []


def test_only_storage_and_the_query_plan_speak_sql() -> None:
    allowed = ("storage/", "xpath/plan.py", "actions/keeping/keep_store.py")
    service = ROOT / "service/mcml_service"
    for path in service.rglob("*.py"):
        name = path.relative_to(service).as_posix()
        if not name.startswith(allowed):
            assert "import sqlalchemy" not in path.read_text(), name
            assert "from sqlalchemy" not in path.read_text(), name


def test_one_module_writes_addresses() -> None:
    """Addresses in frames, and of attributes, are made and taken apart by `mcml.language.addresses`."""
    made = re.compile(r"""/mcml/motion/frame\\?\[|\}/@\{|/frame_bone\[\{|/motion_name\[\{""")
    for path in (ROOT / "service").rglob("*.py"):
        if path.name != "addresses.py" and not path.is_relative_to(ROOT / "service/mcml_service/api"):
            strings = [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.JoinedStr)]
            assert not [text for text in map(ast.unparse, strings) if made.search(text)], path
