"""What changes touch: each drill patches a copy of the program in as many files as CONTRIBUTING names, and it works.

`make test` puts all patches into one copy, and checks them in one process. `make fuzz` starts each check, the
generators and the tests of the documentation as a user does, and puts each patch into a copy of its own too: so it
finds a patch that works only beside another one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.drills.patched_copy import PatchedCopy, count_named_files

PATCHES = Path(__file__).parent / "patches"
FORM = '''def write_tsv(batches: Batches, about: About) -> Iterator[bytes]:
    """Batches as values between tabs, with a row of names."""
    for number, batch in enumerate(batches):
        rows = zip(*(np.asarray(column).tolist() for column in batch.values()), strict=True)
        head = [tuple(batch)] if number == 0 else []
        yield "".join("\\t".join(map(str, row)) + "\\n" for row in (*head, *rows)).encode()


'''
PROPERTY = '    captured: str | None = Field(None, description="When it was captured")\n'
SHOWN = "        captured=stored.captured,\n"
OVERRIDE = """    looks = 0

    @contextmanager
    def looking(self) -> Iterator[Connection]:
        SQLite.looks += 1
        with self.reading() as connection:
            yield connection

"""


def patch(name: str) -> str:
    """Return a file that a patch adds, or a check of it."""
    return (PATCHES / name).read_text(encoding="utf-8")


def add_format(copy: PatchedCopy) -> None:
    copy.add("mcml/formats/plain.py", patch("format.py"))
    copy.add("docs/formats/plain.md", "# Plain\n\nMarkers as `name x y z` lines: part `plain`.\n")
    copy.put("mcml/formats/__init__.py", '    "trc": Trc(),\n', '    "plain": Plain(),\n')
    copy.put("mcml/formats/__init__.py", "from mcml.formats.recognition", "from mcml.formats.plain import Plain\n")


def add_property_of_documents(copy: PatchedCopy) -> None:
    tables = "service/mcml_service/storage/core/tables.py"
    copy.put(tables, '    Column("intact", Boolean', '    Column("captured", String(64)),\n')
    documents = "service/mcml_service/storage/documents/documents.py"
    copy.put(documents, "    data_rate: str | None\n", "    captured: str | None\n")
    copy.put("schemas/mcml_schemas/documents.py", "    created: str\n    modified: str\n\n\nclass Bone", PROPERTY)
    copy.put("service/mcml_service/actions/reading/describe_document.py", "        created=stored", SHOWN)


def add_operation(copy: PatchedCopy) -> None:
    copy.add("service/mcml_service/operations/longest.py", patch("operation.py"))
    copy.add("schemas/mcml_schemas/longest.py", patch("operation_schema.py"))
    row = (
        '    Operation("find_longest", "GET /longest", READS, READ,\n'
        '              "The document with the most frames.", "longest", "longest"),\n'
    )
    copy.put("service/mcml_service/operations/__init__.py", '    Operation("list_formats"', row)


def add_analysis(copy: PatchedCopy) -> None:
    copy.add("service/mcml_service/analysis/travel/__init__.py", patch("analysis.py"))
    copy.add("schemas/mcml_schemas/analyses/travel.py", patch("analysis_schema.py"))
    catalogue = "service/mcml_service/analysis/catalogue.py"
    copy.put(catalogue, "SUBJECTS: Mapping", "from mcml_service.analysis.travel import TRAVEL\n\n\n")
    copy.put(catalogue, '    "reach": {"fit"', '    "travel": {"measure": TRAVEL},\n')


def add_xpath_function(copy: PatchedCopy) -> None:
    functions = "service/mcml_service/xpath/language/functions.py"
    copy.put(functions, '    "abs": _of_number', '    "signum": _of_number(np.sign),\n')


def add_form_of_frames(copy: PatchedCopy) -> None:
    tables = "service/mcml_service/actions/exporting/write_tables.py"
    copy.put(tables, "TABLES: Mapping", FORM)
    copy.put(tables, '    "csv": ("text/csv"', '    "tsv": ("text/tab-separated-values", write_tsv),\n')
    copy.put("schemas/mcml_schemas/frames.py", '"json", "npy", "npz", "block"', '"tsv", ')


def add_setting(copy: PatchedCopy) -> None:
    field = '    motto: str = Field("move", description="What the server says of itself")\n'
    copy.put("service/mcml_service/settings.py", '    login: Literal["auto"', field)
    row = f"| `MCML_{'motto'.upper()}` | `move` | what the server says of itself |\n"
    copy.put("docs/settings.md", "| `MCML_LOGIN` |", row)


def add_what_one_database_does_otherwise(copy: PatchedCopy) -> None:
    sqlite = "service/mcml_service/storage/core/dialects/sqlite.py"
    copy.put(sqlite, "    @contextmanager\n    def writing", OVERRIDE)


@dataclass(frozen=True)
class Drill:
    """A patch, and the program that shows that it works.

    generated: whether generated documentation and types change. migration: its name, where the tables change.
    """

    patch: Callable[[PatchedCopy], None]
    check: str
    generated: bool = False
    migration: str = ""


DRILLS: Mapping[str, Drill] = {
    "a file format": Drill(add_format, "format_check.py"),
    "a property of documents": Drill(add_property_of_documents, "property_check.py", migration="add_captured"),
    "an operation: route, command, Python call": Drill(add_operation, "operation_check.py", generated=True),
    "an analysis": Drill(add_analysis, "analysis_check.py", generated=True),
    "an XPath function of numbers or texts": Drill(add_xpath_function, "function_check.py"),
    "a form of frames as numbers": Drill(add_form_of_frames, "form_check.py", generated=True),
    "a setting": Drill(add_setting, "setting_check.py"),
    "what one database does otherwise": Drill(add_what_one_database_does_otherwise, "override_check.py"),
}
"""By row of "Where to add what" in CONTRIBUTING."""


IN_ONE_PROCESS = """
import pathlib, runpy, sys
migration, *checks = sys.argv[1:]
sys.argv[1:] = [migration]
for module in ("tests.drills.migration", "tests.docs.signatures"):
    runpy.run_module(module, run_name="__main__")
for check in checks:
    exec(compile(check, "check", "exec"), {})
    for left in pathlib.Path().glob("store.db*"):
        left.unlink()
"""


def patch_copy(folder: Path, rows: Mapping[str, Drill]) -> PatchedCopy:
    """Put patches into one copy, each into as many files as its row of CONTRIBUTING names."""
    copy = PatchedCopy(folder / "copy")
    for row, drill in rows.items():
        copy.touched.clear()
        drill.patch(copy)
        assert len(copy.touched) == count_named_files(row), (row, sorted(copy.touched))
    return copy


def try_drills(folder: Path, rows: Mapping[str, Drill]) -> None:
    """Check patches in one copy, each with programs of its own."""
    copy = patch_copy(folder, rows)
    for drill in rows.values():
        if drill.migration:
            copy.run("-m", "tests.drills.migration", drill.migration)
    if any(drill.generated for drill in rows.values()):
        # As `make docs`.
        copy.run("-c", "import tests.docs.generate as g; [p.write_text(g.renewed(p.read_text())) for p in g.PAGES]")
        copy.run("-m", "tests.docs.signatures")
    for drill in rows.values():
        copy.run("-c", patch(drill.check))
        for left in copy.folder.glob("store.db*"):
            left.unlink()
    copy.run("-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/docs/test_docs.py", "-k", "not links")


@pytest.mark.slow
def test_all_patches_work(tmp_path: Path) -> None:
    copy = patch_copy(tmp_path, DRILLS)
    (migration,) = filter(None, (drill.migration for drill in DRILLS.values()))
    # The last one counts what was asked of the store in its process.
    checks = [patch(drill.check) for drill in reversed(DRILLS.values())]
    copy.run("-c", IN_ONE_PROCESS, migration, *checks)


@pytest.mark.fuzz
def test_all_patches_together(tmp_path: Path) -> None:
    try_drills(tmp_path, DRILLS)


@pytest.mark.fuzz
@pytest.mark.parametrize("row", DRILLS)
def test_each_patch_alone(tmp_path: Path, row: str) -> None:
    try_drills(tmp_path, {row: DRILLS[row]})
