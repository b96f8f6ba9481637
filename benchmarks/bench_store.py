"""Loading, sizes, label counts and edits: SQLite store against BaseX (text and attribute index on), lxml, simdjson."""

from __future__ import annotations

import re
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import simdjson
from lxml import etree

from benchmarks import basex, basex_client
from benchmarks.basex_client import BaseXClient
from benchmarks.library import clips, load, load_together, longer, served, write_plain
from benchmarks.timing import median_seconds, report
from mcml.language.writer import write_document
from mcml_service.actions.editing.single_element import Change
from mcml_service.clips.read_clip import read_clip
from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter
from tests.edits import change_element

ASKED = 100
"""Label counts timed, before an edit and after it; each with a constant not asked before."""

TIMES = 5
"""How much longer than the files at hand the clips of the usual library are."""


ROUNDS = {"short": 6, "usual": 2, "large": 3}
"""How often a library is parsed, imported and loaded by BaseX, all in turn: no machine is equally fast for long."""


def run() -> dict[str, object]:
    what, files = clips()
    figures: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as place, _basex(Path(place)) as client:
        folder = Path(place)
        for name, library in (("short", files), ("usual", longer(files, TIMES)), ("large", _large(files))):
            text = sum(len(content) for _, content in library)
            said = what if name == "short" else f"{what}, each followed by variations of itself"
            print(f"   {name}: {len(library)} {said}, {text / 1e6:.1f} MB")
            (folder / name).mkdir()
            figures[name] = _sizes(folder / name, library, text) | _loading(folder / name, library, text, client)
        database = Database(f"sqlite:///{folder / 'usual' / 'store.db'}")
        figures |= _writing(database)
        if client is not None:
            figures |= _against_basex(folder, figures)
        with served(database.url) as http:
            figures["label_count_above_empty_ms"] = report(
                "label count over HTTP, ms above the same route asked q=1", _counts(http, first=0), "<= 1"
            )
            figures["edit_ms"] = report("one value of one frame_bone edited, ms", _edit(database) * 1e3)
            figures["label_count_above_empty_after_edit_ms"] = report(
                "the same count after an edit", _counts(http, first=ASKED), "<= 1"
            )
        database.close()
    return figures


@contextmanager
def _basex(folder: Path) -> Iterator[BaseXClient | None]:
    """A session with a server of BaseX, None where it is not installed."""
    if not basex.available():
        print("   BaseX is not installed (Debian package basex): its ratios are left out")
        yield None
        return
    (folder / "basex").mkdir()
    with basex_client.serving(folder / "basex") as client:
        yield client


def _large(files: list[tuple[str, bytes]]) -> list[tuple[str, bytes]]:
    """One large clip: the biggest file, followed by variations of itself, to about 50 MB."""
    longest = max(files, key=lambda item: len(item[1]))
    return longer([longest], max(1, 50_000_000 // len(longest[1])))


def _sizes(folder: Path, files: list[tuple[str, bytes]], text: int) -> dict[str, float]:
    """Sizes of a library's store; leaves store.db and the documents as plain MCML in mcml/."""
    database = Database(f"sqlite:///{folder / 'store.db'}")
    database.migrate()
    load(database, files, labelled=True)
    sizes = database.size()
    (folder / "mcml").mkdir()
    with database.read() as tx:
        for stored in tx.documents.page(DocumentFilter(), after=None, limit=1000):
            write_plain(tx, stored, folder / "mcml" / f"{stored.uuid}.xml")
    database.close()
    lean = sizes["total"] - sizes["uploads"]
    return {
        "size_without_uploads": report("database without kept uploads / BVH text", lean / text, "<= 0.30"),
        "size_with_uploads": report("database with kept uploads / BVH text", sizes["total"] / text, "<= 0.62"),
        "bytes": float(sizes["total"]),
    }


def _loading(folder: Path, files: list[tuple[str, bytes]], text: int, client: BaseXClient | None) -> dict[str, float]:
    """The least time of several rounds for each: bare parse, import file by file and in one call, load by BaseX."""
    parse = _bare_parse(files)
    times: dict[str, list[float]] = {"parse": [], "single": [], "import": [], "basex": []}
    for number in range(ROUNDS[folder.name]):
        times["parse"].append(median_seconds(parse))
        with _fresh_store(folder / f"single{number}.db") as timed:
            times["single"].append(load(timed, files, labelled=False))
        with _fresh_store(folder / f"together{number}.db") as timed:
            times["import"].append(load_together(timed, files))
        if client is not None:
            start = time.perf_counter()
            client.execute(f"CREATE DB {folder.name} {folder / 'mcml'}")
            times["basex"].append(time.perf_counter() - start)
            client.execute(f"DROP DB {folder.name}")
    least = {name: min(found) for name, found in times.items() if found}
    print(f"   {folder.name}: the least of {ROUNDS[folder.name]} rounds")
    figures = {f"{name}_s": report(said, least[name]) for name, said in _TIMED.items() if name in least}
    for name in ("single", "import"):
        figures[f"{name}_MB_per_s"] = report(f"{_TIMED[name][:-3]}, MB of BVH a second", text / least[name] / 1e6)
        figures[f"{name}_to_parse"] = report("  the same / bare simdjson parse", least[name] / least["parse"], "<= 12")
        if client is not None:
            ratio = least["basex"] / least[name]
            figures[f"basex_to_{name}"] = report("  BaseX's load / the same", ratio, ">= 15")
    return figures


_TIMED = {
    "parse": "bare simdjson parse of all numbers, s",
    "single": "import file by file, upload kept, s",
    "import": "import of all in one call, upload kept, s",
    "basex": "BaseX loads the same as MCML, s",
}


@contextmanager
def _fresh_store(path: Path) -> Iterator[Database]:
    database = Database(f"sqlite:///{path}")
    database.migrate()
    yield database
    database.close()
    path.unlink()


def _bare_parse(files: list[tuple[str, bytes]]) -> Callable[[], None]:
    """Parses the numbers alone with simdjson, the text made JSON beforehand."""
    parser = simdjson.Parser()
    texts = []
    for _, content in files:
        numbers = re.split(rb"Frame\s+Time:\s*\S+", content, flags=re.IGNORECASE)[1]
        joined = b",".join(re.sub(rb"^([-]?)\.", rb"\g<1>0.", token) for token in numbers.split())
        texts.append(b"[" + joined + b"]")

    def parse() -> None:
        for text in texts:
            numbers: Any = parser.parse(text)
            numbers.as_buffer(of_type="d")

    return parse


def _writing(database: Database) -> dict[str, float]:
    with database.read() as tx:
        stored = max(tx.documents.page(DocumentFilter(), after=None, limit=1000), key=lambda item: item.frames)
        source = read_clip(tx, stored)
        blocks = list(source.clip.blocks())

    def ours() -> None:
        for _ in write_document(source.document, stored.frames, stored.frame_time, blocks, source.names):
            pass

    def theirs() -> None:
        with tempfile.TemporaryFile() as target, etree.xmlfile(target) as out, out.element("motion"):
            for block in blocks:
                for frame_id, row in zip(block.ids, block.values.tolist(), strict=True):
                    with out.element("frame", id=str(frame_id)):
                        bones: dict[int, dict[str, str]] = {}
                        for (bone, channel), value in zip(block.columns, row, strict=True):
                            bones.setdefault(bone, {"name": source.names[bone]})[_CHANNELS[channel]] = repr(value)
                        for attributes in bones.values():
                            out.write(etree.Element("frame_bone", attributes))

    ratio = median_seconds(theirs, 3) / median_seconds(ours)
    return {"mcml_writing": report("MCML writing, times lxml's xmlfile", ratio, ">= 10")}


_CHANNELS = ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz", "SF", "residual")


def _against_basex(folder: Path, figures: dict[str, Any]) -> dict[str, float]:
    """Sizes, and label counts before and after an edit, by BaseX's own clock in a JVM of its own."""
    first = min((folder / "usual" / "mcml").glob("*.xml"))
    counts = [f"XQUERY count(//frame[motion_name='move-{number}'])" for number in range(30)]
    more = [f"XQUERY count(//frame[motion_name='move-{number}'])" for number in range(100, 130)]
    edit = f"XQUERY replace value of node doc('usual/{first.name}')//frame[1]/frame_bone[1]/@Rx with '1.5'"
    done = basex.run(
        [
            f"CREATE DB short {folder / 'short' / 'mcml'}",
            f"CREATE DB usual {folder / 'usual' / 'mcml'}",
            *counts,
            edit,
            *more,
        ]
    )
    result = {}
    for name in ("short", "usual"):
        ratio = figures[name]["bytes"] / done.bytes[name]
        result[f"basex_size_ratio_{name}"] = report(f"our {name} database with uploads / BaseX's", ratio, "<= 0.2")
    before, after = done.queries[: len(counts)], done.queries[-len(more) :]
    result["basex_count_ms"] = report("BaseX label count, ms", statistics.median(before))
    result["basex_count_after_edit_ms"] = report("  after an edit of one value, ms", statistics.median(after))
    return result


def _counts(client: httpx.Client, first: int) -> float:
    """Median milliseconds of label counts, each of a name not asked before, above those of `q=1`."""

    def asked(expression: str) -> float:
        start = time.perf_counter()
        client.get("/api/v1/xpath", params={"q": expression}).raise_for_status()
        return (time.perf_counter() - start) * 1e3

    counts, empty = [], []
    for number in range(first, first + ASKED):
        counts.append(asked(f"count(//frame[motion_name='move-{number}'])"))
        empty.append(asked("1"))
    return statistics.median(counts[5:]) - statistics.median(empty[5:])


def _edit(database: Database) -> float:
    times = []
    for number in range(9):
        with database.read() as tx:
            stored = max(tx.documents.page(DocumentFilter(), after=None, limit=1000), key=lambda item: item.frames)
        start = time.perf_counter()
        with database.write() as tx:
            where = f"/mcml/motion/frame[{100 + number}]/frame_bone[2]"
            change_element(tx, tx.documents.get(stored.uuid), where, Change({"Rx": f"{number}.5"}))
        times.append(time.perf_counter() - start)
    return statistics.median(times)
