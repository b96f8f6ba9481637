"""What changes touch: each drill patches a copy of the program in as many files as the README names, and it works."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.drills.patched_copy import PatchedCopy, files_that_the_readme_names

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
OVERRIDE = """    reads = 0

    def rows(self, connection: Connection, statement: Any, values: dict[str, Any]) -> list[tuple[Any, ...]]:
        SQLite.reads += 1
        return super().rows(connection, statement, values)

"""


@pytest.fixture
def copy(tmp_path: Path) -> PatchedCopy:
    return PatchedCopy(tmp_path / "copy")


def patch(name: str) -> str:
    """A file that a patch adds, or a check of it."""
    return (PATCHES / name).read_text(encoding="utf-8")


def check(copy: PatchedCopy, name: str) -> None:
    """Run what shows that the change works, and the tests of the documentation that know of it."""
    copy.run("-c", patch(name))
    copy.run("-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/docs/test_docs.py", "-k", "not links")


def make_docs(copy: PatchedCopy) -> None:
    """As `make docs`: the tables and types that are made of declarations."""
    copy.run("-c", "import tests.docs.generate as g; [p.write_text(g.renewed(p.read_text())) for p in g.PAGES]")
    copy.run("-m", "tests.docs.signatures")


def needs(copy: PatchedCopy, what: str) -> None:
    """A change touches as many files as its row of the README names, and not more."""
    assert len(copy.touched) == files_that_the_readme_names(what), sorted(copy.touched)


def test_a_format(copy: PatchedCopy) -> None:
    copy.add("mcml/formats/plain.py", patch("format.py"))
    copy.add("docs/formats/plain.md", "# Plain\n\nMarkers as `name x y z` lines: part `plain`.\n")
    copy.put("mcml/formats/__init__.py", '    "trc": Trc(),\n', '    "plain": Plain(),\n')
    copy.put("mcml/formats/__init__.py", "from mcml.formats.recognition", "from mcml.formats.plain import Plain\n")
    needs(copy, "a file format")
    check(copy, "format_check.py")


def test_a_property_of_documents(copy: PatchedCopy) -> None:
    tables = "service/mcml_service/storage/core/tables.py"
    copy.put(tables, '    Column("intact", Boolean', '    Column("captured", String(64)),\n')
    documents = "service/mcml_service/storage/documents/documents.py"
    copy.put(documents, "    data_rate: str | None\n", "    captured: str | None\n")
    copy.put("schemas/mcml_schemas/documents.py", "    created: str\n    modified: str\n\n\nclass Bone", PROPERTY)
    copy.put("service/mcml_service/actions/reading/describe_document.py", "        created=stored", SHOWN)
    needs(copy, "a property of documents")
    copy.run("-m", "tests.drills.migration", "add_captured")
    check(copy, "property_check.py")


def test_an_operation(copy: PatchedCopy) -> None:
    copy.add("service/mcml_service/operations/longest.py", patch("operation.py"))
    copy.add("schemas/mcml_schemas/longest.py", patch("operation_schema.py"))
    row = (
        '    Operation("find_longest", "GET /longest", READS, READ,\n'
        '              "The document with the most frames.", "longest", "longest"),\n'
    )
    copy.put("service/mcml_service/operations/__init__.py", '    Operation("list_formats"', row)
    needs(copy, "an operation: route, command, Python call")
    make_docs(copy)
    check(copy, "operation_check.py")


def test_an_analysis(copy: PatchedCopy) -> None:
    copy.add("service/mcml_service/analysis/travel/__init__.py", patch("analysis.py"))
    copy.add("schemas/mcml_schemas/analyses/travel.py", patch("analysis_schema.py"))
    catalogue = "service/mcml_service/analysis/catalogue.py"
    copy.put(catalogue, "SUBJECTS: Mapping", "from mcml_service.analysis.travel import TRAVEL\n\n\n")
    copy.put(catalogue, '    "reach": {"fit"', '    "travel": {"measure": TRAVEL},\n')
    needs(copy, "an analysis")
    make_docs(copy)
    check(copy, "analysis_check.py")


def test_an_xpath_function(copy: PatchedCopy) -> None:
    functions = "service/mcml_service/xpath/language/functions.py"
    copy.put(functions, '    "abs": _of_number', '    "signum": _of_number(np.sign),\n')
    needs(copy, "an XPath function of numbers or texts")
    check(copy, "function_check.py")


def test_a_form_of_frames(copy: PatchedCopy) -> None:
    tables = "service/mcml_service/actions/exporting/write_tables.py"
    copy.put(tables, "TABLES: Mapping", FORM)
    copy.put(tables, '    "csv": ("text/csv"', '    "tsv": ("text/tab-separated-values", write_tsv),\n')
    copy.put("schemas/mcml_schemas/frames.py", '"json", "npy", "npz", "block"', '"tsv", ')
    needs(copy, "a form of frames as numbers")
    make_docs(copy)
    check(copy, "form_check.py")


def test_a_setting(copy: PatchedCopy) -> None:
    field = '    motto: str = Field("move", description="What the server says of itself")\n'
    copy.put("service/mcml_service/settings.py", '    login: Literal["auto"', field)
    row = f"| `MCML_{'motto'.upper()}` | `move` | what the server says of itself |\n"
    copy.put("docs/settings.md", "| `MCML_LOGIN` |", row)
    needs(copy, "a setting")
    check(copy, "setting_check.py")


def test_what_one_database_does_otherwise(copy: PatchedCopy) -> None:
    sqlite = "service/mcml_service/storage/core/dialects/sqlite.py"
    copy.put(sqlite, "    @contextmanager\n    def writing", OVERRIDE)
    needs(copy, "what one database does otherwise")
    check(copy, "override_check.py")
