"""The house: layers, sizes, names, one migration that makes what the tables say."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext

from mcml_service.storage.core.schema import metadata
from mcml_service.storage.database import Database

ROOT = Path(__file__).resolve().parents[2]
LINES = 400
MODULES = 25
SLOW_TO_LOAD = {"interpolate", "ndimage", "optimize", "signal", "sparse", "spatial", "stats"}
ATTICS = {"utils", "util", "helpers", "helper", "common", "manager", "misc", "shared", "tools", "stuff", "general"}


def sources() -> list[Path]:
    """The project's own modules: what is built for the studio, and its packages, are not."""
    folders = ("service", "schemas", "mcml", "benchmarks", "tests")
    found = [path for folder in folders for path in (ROOT / folder).rglob("*.py")]
    return [path for path in found if not {"static", "node_modules"} & set(path.parts)]


def test_a_start_loads_no_parts_of_scipy() -> None:
    """They take longer to load than the program itself; `import scipy` loads a part where it is first used."""
    script = "import sys, mcml_service.app; print([name for name in sys.modules if name.startswith('scipy.')])"
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    assert not set(ast.literal_eval(done.stdout)) & {f"scipy.{part}" for part in SLOW_TO_LOAD}


def test_layers() -> None:
    command = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run([command], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


PLANTS = {
    "service/mcml_service/storage/documents/rows.py": (
        "mcml_service.settings",
        "mcml_service.actions.editing.frame_labels",
    ),
    "mcml/motion/clip.py": ("sqlalchemy", "mcml.formats"),
    "mcml/numerics/runs.py": ("mcml.motion.clip", "pydantic"),
    "mcml/processes/programs.py": ("mcml_service.settings", "mcml_service.xpath.limits"),
    "mcml/formats/bvh/format.py": ("mcml.language.element", "pydantic"),
    "service/mcml_service/analysis/dance/bars.py": ("pydantic", "mcml_service.analysis.reach_blending.fit", "fastapi"),
    "mcml/language/element.py": ("mcml_schemas.problem", "mcml_service.storage.documents.rows"),
    "service/mcml_service/jobs/worker.py": ("fastapi", "mcml_service.api.problems"),
    "service/mcml_service/actions/reading/read_clip.py": ("mcml_service.actions.editing.frame_labels",),
    "service/mcml_service/actions/labelling/edit_labels.py": ("mcml_service.actions.exporting.export_motion",),
    "schemas/mcml_schemas/problem.py": ("mcml.errors",),
    "mcml/files/open_clip.py": ("mcml.client.client", "mcml_service.settings"),
    "service/mcml_service/operations/call.py": ("fastapi", "mcml_service.api.policy", "mcml.client.client"),
    "mcml/client/client.py": ("mcml_service.cli.terminal.opening", "fastapi"),
}
"""Imports that no module may have: each kind of what the contracts forbid."""


def _linted(tmp_path: Path, plants: dict[str, tuple[str, ...]]) -> str:
    """What import-linter says of the sources with these imports added."""
    left_out = shutil.ignore_patterns("__pycache__", "static", "node_modules", "src")
    for name in ("service", "schemas", "mcml"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=left_out)
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


def test_planted_imports_and_packages_without_a_place_are_found(tmp_path: Path) -> None:
    folders = ("mcml/first_attic", "service/mcml_service/second_attic", "service/mcml_service/actions/third_attic")
    said = " ".join(_linted(tmp_path, PLANTS | {f"{folder}/__init__.py": () for folder in folders}).split())
    for name, modules in PLANTS.items():
        planted_in = name.removesuffix(".py").removeprefix("service/").removeprefix("schemas/").replace("/", ".")
        for module in modules:
            assert f"{planted_in} -> {module}" in said, (planted_in, module)
    for folder in folders:
        assert folder.rpartition("/")[2] in said, folder


def test_files_stay_readable() -> None:
    long = {str(path.relative_to(ROOT)): lines for path in sources() if (lines := path.read_text().count("\n")) > LINES}
    assert not long, "split these at their second reason to change"


def test_folders_stay_readable() -> None:
    modules = Counter(
        path.parent for folder in PACKAGES for path in (ROOT / folder).rglob("*.py") if path.stem[0] != "_"
    )
    full = {str(folder.relative_to(ROOT)): count for folder, count in modules.items() if count > MODULES}
    assert not full, "group the modules of these folders by their subject"


def test_folders_of_the_studio_stay_short() -> None:
    """Nobody finds a file in a list of sixty names; tests count, since they are in the same list."""
    source = ROOT / "service/web/src"
    counts = Counter(path.parent.relative_to(source).as_posix() for path in source.rglob("*") if path.is_file())
    assert "state/session" in counts
    assert not {folder: files for folder, files in counts.items() if files > MODULES}, "split these by subject"


def test_no_attics() -> None:
    assert not [path for path in sources() if path.stem in ATTICS]


PACKAGES = {"mcml": "", "service/mcml_service": "service", "schemas/mcml_schemas": "schemas", "migrations": ""}
"""Folders of modules, and where their names begin."""
FRAMEWORK_CALLS = {"readinto", "writable", "handle_request", "dependencies", "initialize", "send_400_response"}
"""Methods that another library calls."""
SHAPES = {"property", "staticmethod", "classmethod", "cache", "lru_cache", "cached_property", "contextmanager"}
"""Decorators that hand what they decorate to nobody."""
USERS_CALL = {"to_pandas", "open_store", "add_to", "read_plates", "plate_forces", "measure_gait", "with_standing_trial"}
"""What users of the library call, and what is named in pyproject.toml or found by its name."""
FOR_OTHERS = {ROOT / "mcml/testing.py", ROOT / "service/mcml_service/testing.py"}
"""What tests use, here and elsewhere."""


@cache
def _parsed() -> dict[str, ast.Module]:
    """Modules of the program by their names."""
    found = {}
    for folder, base in PACKAGES.items():
        for path in (ROOT / folder).rglob("*.py"):
            if path in FOR_OTHERS:
                continue
            parts = path.relative_to(ROOT / base).with_suffix("").parts
            found[".".join(parts).removesuffix(".__init__")] = ast.parse(path.read_text())
    return found


def _defined(body: list[ast.stmt]) -> Iterator[tuple[str, ast.stmt]]:
    """Functions, classes and constants, but what decorators hand to somebody, and dunders."""
    for node in body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            if isinstance(node, ast.ClassDef) or all(map(_only_shapes, node.decorator_list)):
                yield node.name, node
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            yield from ((target.id, node) for target in targets if isinstance(target, ast.Name))


def _only_shapes(decorator: ast.expr) -> bool:
    words = ast.unparse(decorator).partition("(")[0]
    return words in (
        "property",
        "staticmethod",
        "classmethod",
        "cache",
        "lru_cache",
        "cached_property",
        "contextmanager",
    )


@cache
def _nodes(module: ast.Module) -> list[ast.AST]:
    """All of a module: several tests walk through all modules, which takes seconds each time."""
    return list(ast.walk(module))


def _texts(module: ast.Module) -> set[str]:
    """Words of texts like "module:name"."""
    texts = (node.value for node in _nodes(module) if isinstance(node, ast.Constant) and isinstance(node.value, str))
    return {word for text in texts if " " not in text for word in re.findall(r"\w+", text)}


def _attributes(module: ast.Module) -> set[str]:
    return {node.attr for node in _nodes(module) if isinstance(node, ast.Attribute)}


def _loads(module: ast.Module) -> dict[str, list[int]]:
    """The lines in which each name is read."""
    lines: dict[str, list[int]] = {}
    for node in _nodes(module):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
            lines.setdefault(node.id, []).append(node.lineno)
    return lines


def _imports(module: ast.Module) -> Iterator[tuple[str, str]]:
    for node in _nodes(module):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield from ((node.module, alias.name) for alias in node.names)


def unused(modules: dict[str, ast.Module]) -> list[str]:
    """What is defined for nobody: at the top of a module by who imports it, in classes by its name alone."""
    imported = {pair for module in modules.values() for pair in _imports(module)}
    words = {word for module in modules.values() for word in _texts(module)} | FRAMEWORK_CALLS | USERS_CALL
    reached: dict[str, set[str]] = {}
    for module in modules.values():
        for package, name in _imports(module):
            if f"{package}.{name}" in modules:
                reached.setdefault(f"{package}.{name}", set()).update(_attributes(module))
    used = words.union(*map(_attributes, modules.values()))
    found = []
    for name, module in modules.items():
        loads = _loads(module)
        for defined, node in _defined(module.body):
            named = (name, defined) in imported or defined in words or defined in reached.get(name, ())
            # A function that calls itself alone is unused as well.
            own = range(node.lineno, (node.end_lineno or node.lineno) + 1)
            if not named and all(line in own for line in loads.get(defined, ())):
                found.append(f"{name}: {defined}")
            if isinstance(node, ast.ClassDef):
                methods = [inner for inner in node.body if isinstance(inner, ast.FunctionDef)]
                found += [f"{name}: {defined}.{inner}" for inner, _ in _defined([*methods]) if inner not in used]
    return [one for one in found if not one.endswith("__") and not one.startswith("migrations.")]


@pytest.mark.slow
def test_nothing_is_unused() -> None:
    """Every definition has a user that is no test; planted ones without users are found, also under a name in use."""
    text = "def order_commits(): pass\nclass Planted:\n    def nobody_calls_this(self): pass\n"
    modules = {**_parsed(), "mcml.planted": ast.parse(text)}
    planted = ["mcml.planted: order_commits", "mcml.planted: Planted", "mcml.planted: Planted.nobody_calls_this"]
    found = unused(modules)
    assert [one for one in found if one not in planted] == [], "delete these, or move them to the tests"
    assert found == planted


def test_migrations_make_what_the_tables_say(database: Database) -> None:
    with database.dialect.reading() as connection:
        differences = compare_metadata(MigrationContext.configure(connection), metadata)
    assert differences == []


def speaks_sql(module: ast.Module) -> bool:
    """Whether a module imports SQLAlchemy, or reaches for the connection of a transaction."""
    for node in _nodes(module):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        if any(name.partition(".")[0] in ("sqlalchemy", "psycopg") for name in names):
            return True
        if isinstance(node, ast.Attribute) and node.attr in ("connection", "exec_driver_sql"):
            return True
    return False


def test_only_the_store_speaks_sql() -> None:
    speakers = [name for name, module in _parsed().items() if speaks_sql(module)]
    outside = [name for name in speakers if not name.startswith(("mcml_service.storage.", "migrations."))]
    assert outside == []
    assert speaks_sql(ast.parse("def all(tx):\n    return tx.connection.exec_driver_sql('SELECT 1')"))


EXECUTE = {"execute", "executemany", "executescript", "exec_driver_sql", "scalar", "scalars"}
STATEMENTS = "mcml_service.storage.core.statements"
COLUMN_FILES = "mcml_service.xpath.library.disk."
"""A cache of columns in SQLite files of its own, which are no store."""


def executes_sql(module: ast.Module) -> bool:
    """Whether a module calls a method with which SQLAlchemy, or a driver, executes SQL."""
    calls = (node.func for node in _nodes(module) if isinstance(node, ast.Call))
    return any(isinstance(called, ast.Attribute) and called.attr in EXECUTE for called in calls)


def test_one_module_executes_sql() -> None:
    executing = [name for name, module in _parsed().items() if executes_sql(module)]
    assert [name for name in executing if not name.startswith(("migrations.", COLUMN_FILES))] == [STATEMENTS]
    assert executes_sql(ast.parse("def all(tx):\n    return tx.connection.execute(select(document)).all()"))
    assert executes_sql(ast.parse("def all(driver):\n    return driver.cursor().executemany('DELETE FROM token')"))


def test_one_module_writes_addresses() -> None:
    """Addresses in frames, and of attributes, are made and taken apart by `mcml.language.addresses`."""
    made = re.compile(r"""/mcml/motion/frame\\?\[|\}/@\{|/frame_bone\[\{|/motion_name\[\{""")
    for name, module in _parsed().items():
        if name.startswith("mcml_service.") and not name.startswith("mcml_service.api."):
            strings = [node for node in _nodes(module) if isinstance(node, ast.JoinedStr)]
            assert not [text for text in map(ast.unparse, strings) if made.search(text)], name
